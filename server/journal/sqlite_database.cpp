#include "server/journal/sqlite_database.h"

#include <sqlite3.h>

namespace tandem::server {

Result<SqliteDatabase> SqliteDatabase::open(const std::string& path) {
  return open(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
}

Result<SqliteDatabase> SqliteDatabase::openExisting(const std::string& path) {
  return open(path, SQLITE_OPEN_READWRITE);
}

Result<SqliteDatabase> SqliteDatabase::openToRead(const std::string& path) {
  return open(path, SQLITE_OPEN_READONLY);
}

Result<SqliteDatabase> SqliteDatabase::open(const std::string& path, int mode) {
  sqlite3* handle = nullptr;
  const int flags = mode | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_PRIVATECACHE;
  const int code = sqlite3_open_v2(path.c_str(), &handle, flags, nullptr);
  SqliteDatabase database(handle);  // to be closed even after an error
  if (code != SQLITE_OK) return Error{database.error()};
  sqlite3_extended_result_codes(handle, 1);
  return database;
}

SqliteDatabase::~SqliteDatabase() { sqlite3_close_v2(handle_); }

Status SqliteDatabase::run(const char* sql) {
  if (sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) return Error{error()};
  return {};
}

Result<std::string> SqliteDatabase::ask(const char* sql) {
  Result<SqliteStatement> statement = SqliteStatement::prepare(*this, sql);
  if (!statement) return statement.error();
  switch (statement->next()) {
    case SqliteStatement::Row::row:
      return statement->text(0);
    case SqliteStatement::Row::end:
      return std::string();
    default:
      return Error{error()};
  }
}

void SqliteDatabase::watchLog() {
  // The hook also replaces SQLite's own, which makes the automatic checkpoints.
  const auto note = [](void* frames, sqlite3*, const char*, int count) {
    *static_cast<int*>(frames) = count;
    return SQLITE_OK;
  };
  sqlite3_wal_hook(handle_, note, frames_.get());
}

bool SqliteDatabase::checkpoint() {
  int inLog = 0, copied = 0;
  return sqlite3_wal_checkpoint_v2(handle_, nullptr, SQLITE_CHECKPOINT_PASSIVE, &inLog, &copied) ==
             SQLITE_OK &&
         copied == inLog;
}

Status SqliteDatabase::emptyLog() {
  if (sqlite3_wal_checkpoint_v2(handle_, nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr) != SQLITE_OK)
    return Error{error()};
  return {};
}

Status SqliteDatabase::copyTo(const std::string& path) {
  Result<SqliteDatabase> copy = open(path);
  if (!copy) return Error{path + ": " + copy.error().message};
  sqlite3_backup* backup = sqlite3_backup_init(copy->handle_, "main", handle_, "main");
  if (backup == nullptr) return Error{path + ": " + copy->error()};
  sqlite3_busy_timeout(handle_, 5000);
  const int code = sqlite3_backup_step(backup, -1);  // all pages under one read lock: a snapshot
  sqlite3_backup_finish(backup);
  if (code != SQLITE_DONE) return Error{path + ": " + copy->error()};
  return {};
}

std::string SqliteDatabase::error() const {
  return handle_ == nullptr ? "out of memory" : sqlite3_errmsg(handle_);
}

Result<SqliteStatement> SqliteStatement::prepare(const SqliteDatabase& database, const char* sql) {
  sqlite3_stmt* handle = nullptr;
  if (sqlite3_prepare_v2(database.handle(), sql, -1, &handle, nullptr) != SQLITE_OK)
    return Error{database.error()};
  return SqliteStatement(handle);
}

SqliteStatement::~SqliteStatement() { sqlite3_finalize(handle_); }

SqliteStatement& SqliteStatement::bind(int parameter, std::int64_t value) {
  sqlite3_bind_int64(handle_, parameter + 1, value);
  return *this;
}
SqliteStatement& SqliteStatement::bind(int parameter, double value) {
  sqlite3_bind_double(handle_, parameter + 1, value);
  return *this;
}
SqliteStatement& SqliteStatement::bind(int parameter, const std::string& value) {
  sqlite3_bind_text64(handle_, parameter + 1, value.data(), value.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  return *this;
}

SqliteStatement& SqliteStatement::bindBytes(int parameter, const void* bytes, std::size_t size) {
  sqlite3_bind_blob64(handle_, parameter + 1, bytes, size, SQLITE_TRANSIENT);
  return *this;
}

bool SqliteStatement::run() {
  const int code = sqlite3_step(handle_);
  sqlite3_reset(handle_);
  return code == SQLITE_DONE || code == SQLITE_ROW;
}

SqliteStatement::Row SqliteStatement::next() {
  switch (sqlite3_step(handle_)) {
    case SQLITE_ROW:
      return Row::row;
    case SQLITE_DONE:
      return Row::end;
    default:
      return Row::failed;
  }
}

std::int64_t SqliteStatement::integer(int column) const { return sqlite3_column_int64(handle_, column); }
double SqliteStatement::real(int column) const { return sqlite3_column_double(handle_, column); }
std::string SqliteStatement::text(int column) const {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(handle_, column));
  return bytes == nullptr
             ? std::string()
             : std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column)));
}

}  // namespace tandem::server
