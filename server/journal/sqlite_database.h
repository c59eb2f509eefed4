#pragma once

// The few calls of SQLite that the journal needs, with errors as values.

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "assets/base/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace tandem::server {

class SqliteDatabase {
 public:
  static Result<SqliteDatabase> open(const std::string& path);
  /// Opens a database that must be there.
  static Result<SqliteDatabase> openExisting(const std::string& path);
  /// Opens a database that is there, also while another process writes to it.
  static Result<SqliteDatabase> openToRead(const std::string& path);
  SqliteDatabase(SqliteDatabase&& other) noexcept
      : handle_(std::exchange(other.handle_, nullptr)), frames_(std::move(other.frames_)) {}
  SqliteDatabase& operator=(SqliteDatabase&&) = delete;
  ~SqliteDatabase();

  Status run(const char* sql);
  /// The first column of the first row as text; empty if there is none.
  Result<std::string> ask(const char* sql);
  /// The last error, as SQLite reports it.
  std::string error() const;
  sqlite3* handle() const { return handle_; }

  /// Turns off automatic checkpoints, and lets framesInLog() count from now on.
  void watchLog();
  /// Frames in the write-ahead log after the last commit that wrote.
  int framesInLog() const { return *frames_; }
  /// Copies the log into the database with writes of its own, syncs, and empties the log.
  Status emptyLog();
  /// Copies the whole database to another file, while others write.
  Status copyTo(const std::string& path);
  /// Copies the log into the database and syncs both; true if nothing was left over.
  bool checkpoint();

 private:
  static Result<SqliteDatabase> open(const std::string& path, int mode);
  explicit SqliteDatabase(sqlite3* handle) : handle_(handle) {}
  sqlite3* handle_;
  std::unique_ptr<int> frames_ = std::make_unique<int>(0);  // its address is known to SQLite
};

/// A prepared statement; used again and again. Parameters and columns count from 0.
class SqliteStatement {
 public:
  SqliteStatement() = default;
  static Result<SqliteStatement> prepare(const SqliteDatabase& database, const char* sql);
  SqliteStatement(SqliteStatement&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  SqliteStatement& operator=(SqliteStatement&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~SqliteStatement();

  SqliteStatement& bind(int parameter, std::int64_t value);
  SqliteStatement& bind(int parameter, double value);
  SqliteStatement& bind(int parameter, const std::string& value);
  SqliteStatement& bindBytes(int parameter, const void* bytes, std::size_t size);
  /// Runs to the end and rewinds; false: SqliteDatabase::error() says why.
  bool run();

  enum class Row : std::uint8_t { row, end, failed };
  Row next();
  std::int64_t integer(int column) const;
  double real(int column) const;
  /// Text or bytes.
  std::string text(int column) const;

 private:
  explicit SqliteStatement(sqlite3_stmt* handle) : handle_(handle) {}
  sqlite3_stmt* handle_ = nullptr;
};

}  // namespace tandem::server
