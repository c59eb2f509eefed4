#include "server/sqlite_journal.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>

#include "server/sqlite_database.h"
#include "sync/wire/limits.h"

namespace tandem::server {
namespace {

constexpr const char* kApplicationId = "1414417741";  // "TNDM"
constexpr const char* kSchemaVersion = "1";
// The session time in the database leads the session by an amount between these two.
constexpr sync::Micros kTimeAhead = 4 * sync::kSecond, kLeastAhead = 2 * sync::kSecond;

// The write-ahead log, in frames of one page each. It is grown once to hold kMaxFrames; a checkpoint lets it
// start again from the front. Checkpoints cost several fsyncs, so they wait for a quiet moment unless the log
// is full.
constexpr int kMaxFrames = 1000, kIdleFrames = 100;
constexpr std::uintmax_t kFrameBytes = 4096 + 24, kLogHeaderBytes = 32;
constexpr auto kQuiet = std::chrono::milliseconds(150);

constexpr const char* kSchema = R"(
PRAGMA application_id = 1414417741;
PRAGMA user_version = 1;
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE parts (part INTEGER PRIMARY KEY, owner INTEGER NOT NULL, epoch INTEGER NOT NULL,
  px REAL NOT NULL, py REAL NOT NULL, pz REAL NOT NULL,
  qw REAL NOT NULL, qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL);
CREATE TABLE sites (site INTEGER PRIMARY KEY, role INTEGER NOT NULL, name TEXT NOT NULL,
  red INTEGER NOT NULL, green INTEGER NOT NULL, blue INTEGER NOT NULL, gone INTEGER NOT NULL);
CREATE TABLE nonces (nonce TEXT PRIMARY KEY, expires INTEGER NOT NULL) WITHOUT ROWID;
INSERT INTO meta VALUES ('session_time', '0');
)";

/// Marks a new database as a journal of this program, or checks that it is one.
Status checkIdentity(SqliteDatabase& database) {
  // The first read of a file that is no database fails here.
  const Result<std::string> tables = database.ask("SELECT count(*) FROM sqlite_schema");
  if (!tables) return tables.error();
  if (*tables == "0") {
    if (Status made = database.run((std::string("BEGIN IMMEDIATE;") + kSchema + "COMMIT;").c_str()); !made)
      return made;
    return {};
  }
  const Result<std::string> id = database.ask("PRAGMA application_id");
  if (!id) return id.error();
  if (*id != kApplicationId) return Error{"a database of another program"};
  const Result<std::string> version = database.ask("PRAGMA user_version");
  if (!version) return version.error();
  if (*version != kSchemaVersion)
    return Error{"schema version " + *version + ", this server knows version " + kSchemaVersion};
  const Result<std::string> sound = database.ask("PRAGMA quick_check(1)");
  if (!sound) return sound.error();
  if (*sound != "ok") return Error{"damaged: " + *sound};
  return {};
}

Status checkScene(SqliteDatabase& database, const std::string& sceneHash) {
  const Result<std::string> kept = database.ask("SELECT value FROM meta WHERE key = 'scene'");
  if (!kept) return kept.error();
  if (*kept == sceneHash) return {};
  if (!kept->empty())
    return Error{"belongs to another scene (" + kept->substr(0, 12) + "..., this one is " +
                 sceneHash.substr(0, 12) + "...): choose another --data"};
  Result<SqliteStatement> note = SqliteStatement::prepare(database, "INSERT INTO meta VALUES ('scene', ?)");
  if (!note) return note.error();
  if (!note->bind(0, sceneHash).run()) return Error{database.error()};
  return {};
}

/// Runs a query and hands each row to `read`, which returns whether the row is sound.
template <typename Read>
Status readRows(SqliteDatabase& database, const char* sql, const char* table, Read read) {
  Result<SqliteStatement> rows = SqliteStatement::prepare(database, sql);
  if (!rows) return rows.error();
  for (;;) {
    const auto row = rows->next();
    if (row == SqliteStatement::Row::end) return {};
    if (row == SqliteStatement::Row::failed) return Error{database.error()};
    if (!read(*rows)) return Error{std::string("damaged: table ") + table + " holds a value out of range"};
  }
}

bool within(std::int64_t value, std::int64_t least, std::int64_t most) {
  return value >= least && value <= most;
}

bool readPart(const SqliteStatement& row, JournalContents& contents) {
  if (!within(row.integer(0), 0, kNoPart - 1) || !within(row.integer(1), 0, 0xffff) ||
      !within(row.integer(2), 0, 0xffffffff))
    return false;
  sync::PartRecord part;
  part.part = static_cast<PartId>(row.integer(0));
  part.owner = static_cast<SiteId>(row.integer(1));
  part.epoch = static_cast<Epoch>(row.integer(2));
  part.worldFromPart.position = glm::dvec3(row.real(3), row.real(4), row.real(5));
  part.worldFromPart.orientation = glm::dquat(row.real(6), row.real(7), row.real(8), row.real(9));
  contents.parts.push_back(part);
  return isValid(part.worldFromPart);
}

bool readSite(const SqliteStatement& row, JournalContents& contents) {
  if (!within(row.integer(0), 1, 0xffff) ||
      !within(row.integer(1), 0, static_cast<int>(sync::Role::instructor)))
    return false;
  SiteRecord site;
  site.info.site = static_cast<SiteId>(row.integer(0));
  site.info.role = static_cast<sync::Role>(row.integer(1));
  site.info.name = row.text(2);
  for (int i = 0; i < 3; ++i) {
    if (!within(row.integer(3 + i), 0, 255)) return false;
    site.info.colour[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(row.integer(3 + i));
  }
  site.info.connected = false;
  site.left = row.integer(6) != 0;
  contents.sites.push_back(site);
  return site.info.name.size() <= sync::kMaxNameLength;
}

Result<JournalContents> readContents(SqliteDatabase& database) {
  JournalContents contents;
  Status status =
      readRows(database, "SELECT part, owner, epoch, px, py, pz, qw, qx, qy, qz FROM parts ORDER BY part",
               "parts", [&](const SqliteStatement& row) { return readPart(row, contents); });
  if (!status) return status.error();
  status = readRows(database, "SELECT site, role, name, red, green, blue, gone FROM sites ORDER BY site",
                    "sites", [&](const SqliteStatement& row) { return readSite(row, contents); });
  if (!status) return status.error();
  status = readRows(database, "SELECT nonce, expires FROM nonces", "nonces", [&](const SqliteStatement& row) {
    contents.nonces.push_back({row.text(0), row.integer(1)});
    return true;
  });
  if (!status) return status.error();
  status = readRows(database, "SELECT CAST(value AS INTEGER) FROM meta WHERE key = 'session_time'", "meta",
                    [&](const SqliteStatement& row) {
                      contents.sessionTime = row.integer(0);
                      return contents.sessionTime >= 0;
                    });
  if (!status) return status.error();
  return contents;
}

/// Writes zeros behind the log's end, once, so that a commit finds its blocks in place: fdatasync then has no
/// new file size or block map to write, which would be a second access to the disk. SQLite reads zeros as the
/// end of the log (they have no valid checksum), and its locks are on other files.
Status growLog(const std::string& path) {
  const int file = ::open((path + "-wal").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) return Error{std::strerror(errno)};
  struct stat now {};
  bool good = ::fstat(file, &now) == 0;
  const std::vector<char> zeros(std::size_t{64} * 1024, 0);
  constexpr auto kWanted = static_cast<off_t>(kLogHeaderBytes + kMaxFrames * kFrameBytes);
  for (off_t at = now.st_size; good && at < kWanted;) {
    const auto size = std::min(zeros.size(), static_cast<std::size_t>(kWanted - at));
    const ssize_t written = ::pwrite(file, zeros.data(), size, at);
    good = written > 0;
    at += written;
  }
  good = good && ::fsync(file) == 0;
  const int error = errno;
  ::close(file);
  return good ? Status{} : Error{std::string("write-ahead log: ") + std::strerror(error)};
}

/// The statements by which records are written.
struct Writer {
  SqliteStatement begin, commit, rollback, part, site, nonce, time;

  static Result<Writer> prepare(const SqliteDatabase& database) {
    Writer writer;
    const struct {
      SqliteStatement* statement;
      const char* sql;
    } all[] = {
        {&writer.begin, "BEGIN IMMEDIATE"},
        {&writer.commit, "COMMIT"},
        {&writer.rollback, "ROLLBACK"},
        {&writer.part, "INSERT OR REPLACE INTO parts VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"},
        {&writer.site, "INSERT OR REPLACE INTO sites VALUES (?, ?, ?, ?, ?, ?, ?)"},
        {&writer.nonce, "INSERT OR REPLACE INTO nonces VALUES (?, ?)"},
        {&writer.time, "UPDATE meta SET value = ? WHERE key = 'session_time'"},
    };
    for (const auto& [statement, sql] : all) {
      Result<SqliteStatement> prepared = SqliteStatement::prepare(database, sql);
      if (!prepared) return prepared.error();
      *statement = std::move(*prepared);
    }
    return writer;
  }

  bool write(const sync::PartRecord& r) {
    const auto& p = r.worldFromPart.position;
    const auto& q = r.worldFromPart.orientation;
    part.bind(0, std::int64_t{r.part}).bind(1, std::int64_t{r.owner}).bind(2, std::int64_t{r.epoch});
    part.bind(3, p.x).bind(4, p.y).bind(5, p.z);
    return part.bind(6, q.w).bind(7, q.x).bind(8, q.y).bind(9, q.z).run();
  }
  bool write(const SiteRecord& r) {
    site.bind(0, std::int64_t{r.info.site})
        .bind(1, static_cast<std::int64_t>(r.info.role))
        .bind(2, r.info.name);
    for (int i = 0; i < 3; ++i) site.bind(3 + i, std::int64_t{r.info.colour[static_cast<std::size_t>(i)]});
    return site.bind(6, std::int64_t{r.left}).run();
  }
  bool write(const UsedNonce& r) { return nonce.bind(0, r.nonce).bind(1, r.expires).run(); }
  bool writeTime(sync::Micros value) { return time.bind(0, std::to_string(value)).run(); }

  /// One transaction. Any failure undoes all of it.
  bool commitBatch(const std::vector<JournalRecord>& records, sync::Micros sessionTime) {
    if (!begin.run()) return false;
    for (const JournalRecord& record : records)
      if (!std::visit([&](const auto& r) { return write(r); }, record)) return false;
    return (sessionTime == 0 || writeTime(sessionTime)) && commit.run();
  }
};

}  // namespace

struct SqliteJournal::State {
  std::string path;
  SqliteDatabase database;
  Writer writer;
  JournalContents contents;

  // The caller's thread.
  std::uint64_t appended = 0;
  sync::Micros latestTime = 0, timeAhead = 0;

  std::mutex mutex;  // guards what follows
  std::condition_variable wanted;
  std::vector<JournalRecord> queue;
  sync::Micros queuedTime = 0;  // 0: none
  bool stopping = false;
  std::string failure;
  std::function<void()> callback;

  std::atomic<std::uint64_t> durable{0};
  std::atomic<bool> failed{false};
  std::thread thread;

  State(std::string thePath, SqliteDatabase theDatabase, Writer theWriter, JournalContents theContents)
      : path(std::move(thePath)),
        database(std::move(theDatabase)),
        writer(std::move(theWriter)),
        contents(std::move(theContents)),
        latestTime(contents.sessionTime),
        timeAhead(contents.sessionTime) {}

  // The writer's thread.
  int frames = 0;                  // in the log, as of the last commit
  int checkpointAt = kIdleFrames;  // frames from which a quiet moment is used

  void work();
  bool drain(std::vector<JournalRecord>& batch, sync::Micros& time);
  void checkpoint();
  void finish(bool good, std::size_t count);
};

/// Waits for work and drains the queue; makes a checkpoint in a quiet moment. False when the thread is to
/// stop.
bool SqliteJournal::State::drain(std::vector<JournalRecord>& batch, sync::Micros& time) {
  const auto some = [&] { return stopping || !queue.empty() || queuedTime != 0; };
  std::unique_lock lock(mutex);
  if (frames >= checkpointAt && !wanted.wait_for(lock, kQuiet, some)) {
    lock.unlock();
    checkpoint();
    lock.lock();
  }
  wanted.wait(lock, some);
  if (queue.empty() && queuedTime == 0) return false;
  batch.clear();
  std::swap(batch, queue);
  time = std::exchange(queuedTime, 0);
  return true;
}

/// Moves what the log holds into the database, so that the log starts again from the front. If that fails
/// nothing is lost: the records are safe in the log, which keeps growing.
void SqliteJournal::State::checkpoint() {
  const bool done = database.checkpoint();
  checkpointAt = done ? kIdleFrames : frames + kIdleFrames;
  if (done) frames = 0;
}

/// The writer's thread: writes everything that is queued as one transaction, then notifies.
void SqliteJournal::State::work() {
  std::vector<JournalRecord> batch;
  sync::Micros time = 0;
  while (drain(batch, time)) {
    const bool good = writer.commitBatch(batch, time);
    finish(good, batch.size());
    if (!good) return;
    frames = database.framesInLog();
    if (frames >= std::max(kMaxFrames, checkpointAt)) checkpoint();
  }
}

void SqliteJournal::State::finish(bool good, std::size_t count) {
  std::function<void()> notify;
  {
    const std::lock_guard lock(mutex);
    if (good) {
      durable.fetch_add(count, std::memory_order_release);
    } else {
      failure = path + ": " + database.error();
      writer.rollback.run();
      queue.clear();
      failed.store(true, std::memory_order_release);
    }
    notify = callback;
  }
  if (notify && (count > 0 || !good)) notify();
}

Result<std::unique_ptr<SqliteJournal>> SqliteJournal::open(const std::string& path,
                                                           const SqliteJournalOptions& options) {
  const auto failed = [&](const Error& error) { return Error{path + ": " + error.message}; };
  Result<SqliteDatabase> database = SqliteDatabase::open(path);
  if (!database) return failed(database.error());
  if (Status ours = checkIdentity(*database); !ours) return failed(ours.error());
  if (Status scene = checkScene(*database, options.sceneHash); !scene) return failed(scene.error());
  const std::string settings =
      "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA busy_timeout = 2000;" +
      (options.maxPages == 0 ? std::string()
                             : "PRAGMA max_page_count = " + std::to_string(options.maxPages) + ";") +
      "DELETE FROM nonces WHERE expires <= " + std::to_string(options.unixNow) + ";";
  if (Status set = database->run(settings.c_str()); !set) return failed(set.error());
  const Result<std::string> mode = database->ask("PRAGMA journal_mode");
  if (!mode || *mode != "wal") return failed(Error{"the file system does not support a write-ahead log"});
  database->watchLog();
  if (Status grown = growLog(path); !grown) return failed(grown.error());
  Result<JournalContents> contents = readContents(*database);
  if (!contents) return failed(contents.error());
  Result<Writer> writer = Writer::prepare(*database);
  if (!writer) return failed(writer.error());
  return std::unique_ptr<SqliteJournal>(new SqliteJournal(
      std::make_unique<State>(path, std::move(*database), std::move(*writer), std::move(*contents))));
}

SqliteJournal::SqliteJournal(std::unique_ptr<State> state) : state_(std::move(state)) {
  state_->thread = std::thread([s = state_.get()] { s->work(); });
}

SqliteJournal::~SqliteJournal() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
    // After an orderly shutdown the time in the database need not lead: session time continues where it was.
    if (state_->latestTime > 0 && state_->failure.empty()) state_->queuedTime = state_->latestTime;
  }
  state_->wanted.notify_one();
  state_->thread.join();
}

void SqliteJournal::onProgress(std::function<void()> callback) {
  const std::lock_guard lock(state_->mutex);
  state_->callback = std::move(callback);
}

JournalContents SqliteJournal::contents() const { return state_->contents; }

std::uint64_t SqliteJournal::append(const JournalRecord& record) {
  ++state_->appended;
  if (!state_->failed.load(std::memory_order_acquire)) {
    {
      const std::lock_guard lock(state_->mutex);
      state_->queue.push_back(record);
    }
    state_->wanted.notify_one();
  }
  return state_->appended;
}

void SqliteJournal::noteTime(sync::Micros sessionTime) {
  if (sessionTime <= state_->latestTime) return;
  state_->latestTime = sessionTime;
  if (sessionTime + kLeastAhead <= state_->timeAhead || state_->failed.load(std::memory_order_acquire))
    return;
  state_->timeAhead = sessionTime + kTimeAhead;
  {
    const std::lock_guard lock(state_->mutex);
    state_->queuedTime = state_->timeAhead;
  }
  state_->wanted.notify_one();
}

std::uint64_t SqliteJournal::durableUpTo() { return state_->durable.load(std::memory_order_acquire); }

std::string SqliteJournal::failure() const {
  if (!state_->failed.load(std::memory_order_acquire)) return {};
  const std::lock_guard lock(state_->mutex);
  return state_->failure;
}

}  // namespace tandem::server
