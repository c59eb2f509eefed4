#include "server/operation/audit_log.h"

#include <sys/stat.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <iterator>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "assets/base/assert.h"
#include "assets/base/utc_time.h"
#include "server/journal/sqlite_database.h"

namespace tandem::server {
namespace {

constexpr std::size_t kMaxQueued = 4096;
constexpr auto kRetry = std::chrono::seconds(1);
constexpr const char* kApplicationId = "1414415684";  // "TNAD"

constexpr const char* kSchema = R"(BEGIN IMMEDIATE;
PRAGMA application_id = 1414415684;
CREATE TABLE audit (number INTEGER PRIMARY KEY, time INTEGER NOT NULL, event TEXT NOT NULL,
  site INTEGER NOT NULL, name TEXT NOT NULL, role TEXT NOT NULL, address TEXT NOT NULL, detail TEXT NOT NULL);
COMMIT;)";

Status prepareTable(SqliteDatabase& database) {
  const Result<std::string> tables = database.ask("SELECT count(*) FROM sqlite_schema");
  if (!tables) return tables.error();
  if (*tables == "0")
    if (Status made = database.run(kSchema); !made) return made;
  const Result<std::string> id = database.ask("PRAGMA application_id");
  if (!id) return id.error();
  if (*id != kApplicationId) return Error{"no audit table of tandem-server"};
  return {};
}

std::optional<AuditEvent> eventFrom(const std::string& name) {
  for (int i = 0; i < kAuditEvents; ++i)
    if (name == toString(static_cast<AuditEvent>(i))) return static_cast<AuditEvent>(i);
  return std::nullopt;
}

/// The text without what a terminal executes: the table is a file, and names come from strangers.
std::string shown(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, '?');
  return text;
}

}  // namespace

struct AuditLog::State {
  std::string path;
  SqliteDatabase database;
  SqliteStatement insert, trim;
  std::int64_t rows = 0, next = 1;

  std::mutex mutex;  // guards what follows
  std::condition_variable wanted;
  std::deque<AuditEntry> queue;
  std::string news;
  bool stopping = false;
  std::thread thread;

  State(std::string thePath, SqliteDatabase theDatabase)
      : path(std::move(thePath)), database(std::move(theDatabase)) {}

  void work();
  /// Why it was not written; empty: it was.
  std::string write(const std::deque<AuditEntry>& batch);
  bool insertAll(const std::deque<AuditEntry>& batch);
  void keepNewest();
};

bool AuditLog::State::insertAll(const std::deque<AuditEntry>& batch) {
  std::int64_t number = next;
  for (const AuditEntry& entry : batch) {
    insert.bind(0, number++).bind(1, entry.unixTime).bind(2, std::string(toString(entry.event)));
    insert.bind(3, std::int64_t{entry.site}).bind(4, entry.name).bind(5, entry.role);
    if (!insert.bind(6, entry.address).bind(7, entry.detail).run()) return false;
  }
  return trim.bind(0, number - 1 - rows).run();
}

std::string AuditLog::State::write(const std::deque<AuditEntry>& batch) {
  if (Status begun = database.run("BEGIN IMMEDIATE"); !begun) return begun.error().message;
  if (insertAll(batch) && database.run("COMMIT")) {
    next += static_cast<std::int64_t>(batch.size());
    return {};
  }
  std::string reason = database.error();
  static_cast<void>(database.run("ROLLBACK"));
  return reason;
}

/// Drops the oldest queued entries beyond the bound; their numbers stay unused.
void AuditLog::State::keepNewest() {
  for (; queue.size() > kMaxQueued; ++next) queue.pop_front();
}

void AuditLog::State::work() {
  bool failing = false;
  std::unique_lock lock(mutex);
  for (;;) {
    wanted.wait(lock, [&] { return stopping || !queue.empty(); });
    if (queue.empty()) return;
    std::deque<AuditEntry> batch = std::exchange(queue, {});
    lock.unlock();
    const std::string failure = write(batch);
    lock.lock();
    if (failure.empty()) {
      if (std::exchange(failing, false)) news = path + ": written again";
      continue;
    }
    if (!std::exchange(failing, true)) news = path + ": " + failure;
    queue.insert(queue.begin(), std::make_move_iterator(batch.begin()), std::make_move_iterator(batch.end()));
    keepNewest();
    if (stopping) return;
    wanted.wait_for(lock, kRetry, [&] { return stopping; });
  }
}

Result<std::unique_ptr<AuditLog>> AuditLog::open(const std::string& path, std::int64_t rows) {
  ASSERT(rows > 0);
  const auto failed = [&](const Error& error) { return Error{path + ": " + error.message}; };
  Result<SqliteDatabase> database = SqliteDatabase::open(path);
  if (!database) return failed(database.error());
  if (Status ready = prepareTable(*database); !ready) return failed(ready.error());
  ::chmod(path.c_str(), 0600);
  if (Status set = database->run(
          "PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL; PRAGMA busy_timeout = 2000;");
      !set)
    return failed(set.error());
  auto state = std::make_unique<State>(path, std::move(*database));
  state->rows = rows;
  const Result<std::string> last = state->database.ask("SELECT max(number) FROM audit");
  if (!last) return failed(last.error());
  if (!last->empty()) state->next = std::stoll(*last) + 1;
  auto insert =
      SqliteStatement::prepare(state->database, "INSERT INTO audit VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
  auto trim = SqliteStatement::prepare(state->database, "DELETE FROM audit WHERE number <= ?");
  if (!insert || !trim) return failed(Error{state->database.error()});
  state->insert = std::move(*insert);
  state->trim = std::move(*trim);
  return std::unique_ptr<AuditLog>(new AuditLog(std::move(state)));
}

AuditLog::AuditLog(std::unique_ptr<State> state) : state_(std::move(state)) {
  state_->thread = std::thread([s = state_.get()] { s->work(); });
}

AuditLog::~AuditLog() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
  }
  state_->wanted.notify_one();
  state_->thread.join();
}

void AuditLog::note(std::vector<AuditEntry> entries) {
  if (entries.empty()) return;
  {
    const std::lock_guard lock(state_->mutex);
    std::move(entries.begin(), entries.end(), std::back_inserter(state_->queue));
  }
  state_->wanted.notify_one();
}

std::string AuditLog::drainNews() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->news, {});
}

Status readAudit(const std::string& path, const std::function<void(const AuditRow&)>& read) {
  const auto failed = [&](const std::string& reason) { return Error{path + ": " + reason}; };
  struct stat there {};
  if (::stat(path.c_str(), &there) != 0) return failed("no such file");
  Result<SqliteDatabase> database = SqliteDatabase::openToRead(path);
  if (!database) return failed(database.error().message);
  const Result<std::string> id = database->ask("PRAGMA application_id");
  if (!id) return failed(id.error().message);
  if (*id != kApplicationId) return failed("no audit table of tandem-server");
  auto rows = SqliteStatement::prepare(
      *database, "SELECT number, time, event, site, name, role, address, detail FROM audit ORDER BY number");
  if (!rows) return failed(rows.error().message);
  for (;;) {
    const SqliteStatement::Row row = rows->next();
    if (row == SqliteStatement::Row::end) return {};
    if (row == SqliteStatement::Row::failed) return failed(database->error());
    const std::optional<AuditEvent> event = eventFrom(rows->text(2));
    if (!event || rows->integer(3) < 0 || rows->integer(3) > 0xffff)
      return failed("damaged: row " + std::to_string(rows->integer(0)) + " holds a value out of range");
    read({rows->integer(0),
          {*event, rows->integer(1), static_cast<SiteId>(rows->integer(3)), rows->text(4), rows->text(5),
           rows->text(6), rows->text(7)}});
  }
}

std::string inWords(const AuditRow& row) {
  const AuditEntry& entry = row.entry;
  std::string line = utcText(entry.unixTime) + "  " + toString(entry.event);
  line.resize(std::max<std::size_t>(line.size(), 38), ' ');
  if (entry.site != kNoSite) line += " site " + std::to_string(entry.site);
  if (!entry.name.empty()) line += " \"" + entry.name + '"';
  if (!entry.role.empty()) line += ", " + entry.role;
  if (!entry.address.empty()) line += ", from " + entry.address;
  if (!entry.detail.empty()) line += ": " + entry.detail;
  return shown(line);
}

std::string inJson(const AuditRow& row) {
  const AuditEntry& entry = row.entry;
  nlohmann::ordered_json object{
      {"number", row.number}, {"time", utcText(entry.unixTime)}, {"event", toString(entry.event)}};
  if (entry.site != kNoSite) object["site"] = entry.site;
  if (!entry.name.empty()) object["name"] = entry.name;
  if (!entry.role.empty()) object["role"] = entry.role;
  if (!entry.address.empty()) object["address"] = entry.address;
  if (!entry.detail.empty()) object["detail"] = entry.detail;
  return object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace tandem::server
