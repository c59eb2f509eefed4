#include "server/journal/sqlite_journal.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>

#include "assets/base/assert.h"
#include "server/journal/session_database.h"
#include "server/journal/session_mark.h"
#include "server/journal/watched_files.h"

namespace tandem::server {
namespace {

// The session time in the database leads the session by an amount between these two.
constexpr sync::Micros kTimeAhead = 4 * sync::kSecond, kLeastAhead = 2 * sync::kSecond;

// The write-ahead log, in frames of one page each. It is grown once to hold kMaxFrames; a checkpoint lets it
// start again from the front. Checkpoints cost several fsyncs, so they wait for a quiet moment unless the log
// is full.
constexpr int kMaxFrames = 1000, kIdleFrames = 100;
constexpr auto kQuiet = std::chrono::milliseconds(150);
constexpr auto kLook = std::chrono::milliseconds(1000);  // between two looks at the files
constexpr auto kRetry = std::chrono::milliseconds(500);  // between two attempts after a failure

// Reserved in the mark beyond what is needed; the next block is reserved when half of it is used.
constexpr Epoch kEpochBlock = 1024;
constexpr std::uint32_t kSiteBlock = 64;

constexpr const char* kAdvice =
    ": put the files back as they were, or run tandem-server --recover, which keeps what is sound";

/// How far records go.
struct Reach {
  Epoch epoch = 0;
  std::uint32_t site = 0;

  void include(const JournalRecord& record) {
    if (const auto* part = std::get_if<sync::PartRecord>(&record)) epoch = std::max(epoch, part->epoch);
    if (const auto* known = std::get_if<SiteRecord>(&record))
      site = std::max(site, std::uint32_t{known->info.site});
  }
  Epoch epochBlock() const { return epoch + std::min(kEpochBlock, ~epoch); }
  std::uint32_t siteBlock() const { return site + kSiteBlock; }
};

/// Whether the database ends where the mark says.
Status checkAgainst(const SessionMark& mark, const DatabaseHead& head) {
  const MarkState& told = mark.state();
  if (told.session != head.session) return Error{"belongs to another session than session.mark"};
  if (head.sequence < told.sequence)
    return Error{"rolled back: it ends at commit " + std::to_string(head.sequence) + ", but commit " +
                 std::to_string(told.sequence) + " was durable"};
  const bool same = head.sequence == told.sequence && head.chain == told.chain;
  // The process may have died between a commit and its note; a loss of power may have taken many notes.
  const bool next = head.sequence == told.sequence + 1 && head.previousChain == told.chain;
  const bool afterPowerLoss = !mark.sameBoot() && head.sequence > told.sequence;
  if (!same && !next && !afterPowerLoss)
    return Error{"commit " + std::to_string(told.sequence) + " is not the one that session.mark knows"};
  return {};
}

}  // namespace

std::string markPathOf(const std::string& databasePath) {
  return std::filesystem::path(databasePath).replace_extension(".mark").string();
}

struct SqliteJournal::State {
  std::string path;
  SqliteJournalOptions options;
  SessionMark mark;
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

  State(std::string thePath, SqliteJournalOptions theOptions, SessionMark theMark,
        SessionDatabase theDatabase)
      : path(std::move(thePath)),
        options(std::move(theOptions)),
        mark(std::move(theMark)),
        contents(theDatabase.contents()),
        database(std::move(theDatabase)) {
    latestTime = timeAhead = contents.sessionTime;
    // After a loss of power a disk that lied may have lost what the mark still knows.
    if (!mark.sameBoot()) contents.epochFloor = std::max(contents.epochFloor, mark.state().epochCeiling);
  }

  // The writer's thread.
  std::optional<SessionDatabase> database;  // none while it cannot be opened
  DatabaseHead head, attempted;             // of the last commit that is told, and of one that failed
  WatchedFiles files, log;                  // the log is another file whenever the database is opened
  std::chrono::steady_clock::time_point looked{};
  int frames = 0;                      // in the log, as of the last commit
  int checkpointAt = kIdleFrames;      // frames from which a quiet moment is used
  std::vector<JournalRecord> pending;  // what a failure kept from the disk
  sync::Micros pendingTime = 0;

  Status start();
  Status settle();
  void work();
  bool drain(std::vector<JournalRecord>& batch, sync::Micros& time);
  void checkpoint();
  void finish(const Status& status, std::size_t count);
  Status write(const std::vector<JournalRecord>& batch, sync::Micros time);
  Status reserveFor(const std::vector<JournalRecord>& batch);
  void reserveAhead();
  bool waitToRetry();
  void retry();
  Status reopen();
  Status look();
};

/// Prepares the opened database for commits.
Status SqliteJournal::State::settle() {
  database->sqlite().watchLog();
  frames = 0;
  checkpointAt = kIdleFrames;
  if (Status grown = database->growLog(path, kMaxFrames); !grown)
    return Error{path + ": " + grown.error().message};
  log = WatchedFiles();
  return log.add(path + "-wal");
}

Status SqliteJournal::State::start() {
  if (Status ready = settle(); !ready) return ready;
  head = attempted = database->head();
  for (const std::string& file : options.watched)
    if (Status added = files.add(file); !added) return added;
  if (Status added = files.add(path); !added) return added;
  if (Status added = files.add(markPathOf(path)); !added) return added;
  if (Status noted = mark.note(head.sequence, head.chain); !noted) return noted;
  // Ceilings that are reserved already stay; a new session has none yet.
  return head.sequence > 1 ? mark.reserve(0, 0) : Status{};
}

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
  batch.clear();
  time = 0;
  if (!wanted.wait_for(lock, kLook, some)) return true;
  if (queue.empty() && queuedTime == 0) return false;
  std::swap(batch, queue);
  time = std::exchange(queuedTime, 0);
  return true;
}

/// Moves what the log holds into the database, so that the log starts again from the front. If that fails
/// nothing is lost: the records are safe in the log, which keeps growing.
void SqliteJournal::State::checkpoint() {
  const bool done = database->sqlite().checkpoint();
  checkpointAt = done ? kIdleFrames : frames + kIdleFrames;
  if (done) frames = 0;
}

/// No epoch and no site number is told beyond the ceilings of the mark.
Status SqliteJournal::State::reserveFor(const std::vector<JournalRecord>& batch) {
  Reach reach;
  for (const JournalRecord& record : batch) reach.include(record);
  const MarkState& state = mark.state();
  if (reach.epoch <= state.epochCeiling && reach.site <= state.siteCeiling && state.epochCeiling > 0)
    return {};
  return mark.reserve(reach.epochBlock(), reach.siteBlock());
}

/// Reserves the next block while nobody waits. A failure shows at the next commit.
void SqliteJournal::State::reserveAhead() {
  Reach reach;
  for (const JournalRecord& record : pending) reach.include(record);
  const MarkState& state = mark.state();
  const bool half = reach.epoch + std::min(kEpochBlock / 2, ~reach.epoch) > state.epochCeiling ||
                    reach.site + kSiteBlock / 2 > state.siteCeiling;
  if (half) (void)mark.reserve(reach.epochBlock(), reach.siteBlock());
}

/// The paths once a second, and at every commit whether the directory was deleted: then nothing counts as
/// durable any more.
Status SqliteJournal::State::look() {
  const auto now = std::chrono::steady_clock::now();
  if (!mark.isDeleted() && now - looked < kLook) return {};
  looked = now;
  if (Status same = files.check(); !same) return same;
  return log.check();
}

Status SqliteJournal::State::write(const std::vector<JournalRecord>& batch, sync::Micros time) {
  if (Status same = look(); !same) return same;
  if (batch.empty() && time == 0) return {};
  if (Status reserved = reserveFor(batch); !reserved) return reserved;
  Status written = database->commit(batch, time);
  attempted = database->attempted();
  if (!written) return Error{path + ": " + written.error().message};
  if (Status noted = mark.note(attempted.sequence, attempted.chain); !noted) return noted;
  head = attempted;
  return {};
}

/// The writer's thread: writes everything that is queued as one transaction, then notifies.
void SqliteJournal::State::work() {
  for (;;) {
    if (failed.load(std::memory_order_relaxed)) {
      if (!waitToRetry()) return;
      retry();
      continue;
    }
    if (!drain(pending, pendingTime)) return;
    const Status status = write(pending, pendingTime);
    finish(status, pending.size());
    if (!status) continue;
    reserveAhead();
    pending.clear();
    pendingTime = 0;
    frames = database->sqlite().framesInLog();
    if (frames >= std::max(kMaxFrames, checkpointAt)) checkpoint();
  }
}

void SqliteJournal::State::finish(const Status& status, std::size_t count) {
  std::function<void()> notify;
  {
    const std::lock_guard lock(mutex);
    if (status) {
      durable.fetch_add(count, std::memory_order_release);
    } else {
      failure = status.error().message;
      failed.store(true, std::memory_order_release);
    }
    notify = callback;
  }
  if (notify && (count > 0 || !status)) notify();
}

/// False when the thread is to stop.
bool SqliteJournal::State::waitToRetry() {
  std::unique_lock lock(mutex);
  return !wanted.wait_for(lock, kRetry, [&] { return stopping; });
}

/// Opens the files anew, and writes what was pending and what was appended meanwhile.
void SqliteJournal::State::retry() {
  if (!reopen()) return;
  for (;;) {
    if (!write(pending, pendingTime)) return;
    std::function<void()> notify;
    {
      const std::lock_guard lock(mutex);
      durable.fetch_add(pending.size(), std::memory_order_release);
      pending.clear();
      pendingTime = std::exchange(queuedTime, 0);
      std::swap(pending, queue);
      if (pending.empty() && pendingTime == 0) {
        failure.clear();
        failed.store(false, std::memory_order_release);
        notify = callback;
      }
    }
    if (!failed.load(std::memory_order_relaxed)) {
      if (notify) notify();
      return;
    }
  }
}

/// Opens the files anew and verifies that they end with the last commit, or with the one that failed.
///
/// After a sync that failed, the system may hold pages of the log in memory that it takes for written, and
/// the next sync passes over them. Nothing in the log counts as durable before a checkpoint has written it
/// again, into the database, and synced that.
Status SqliteJournal::State::reopen() {
  if (Status same = files.check(); !same) return same;
  database.reset();
  auto opened = SessionDatabase::open(path, options.maxPages);
  if (!opened) return opened.error();
  const DatabaseHead& found = opened->head();
  const bool before = found.sequence == head.sequence && found.chain == head.chain;
  const bool after = found.sequence == attempted.sequence && found.chain == attempted.chain;
  if (!before && !after) return Error{path + ": it is not as this server left it"};
  database.emplace(std::move(*opened));
  if (Status emptied = database->sqlite().emptyLog(); !emptied) return emptied;
  if (Status ready = settle(); !ready) return ready;
  if (before) return {};
  // The commit that failed has come through all the same.
  if (Status noted = mark.note(attempted.sequence, attempted.chain); !noted) return noted;
  head = attempted;
  const std::lock_guard lock(mutex);
  durable.fetch_add(pending.size(), std::memory_order_release);
  pending.clear();
  pendingTime = 0;
  return {};
}

namespace {

/// A new session, if nothing of an earlier one is here.
Result<SessionDatabase> begin(const std::string& path, const SqliteJournalOptions& options) {
  DatabaseHead head;
  head.session = randomDigest();
  head.scene = options.sceneHash;
  // The mark first: it says that nothing was told yet, so that a start that is cut off here can begin again.
  auto mark = SessionMark::create(markPathOf(path), {head.session, options.key, 0, 0, 0, {}});
  if (!mark) return mark.error();
  return SessionDatabase::create(path, head, {}, options.maxPages);
}

/// Whether the files are those of a first start that was cut off: nothing of the session was ever told.
bool isUntold(const SessionMark& mark) {
  return mark.state().epochCeiling == 0 && mark.state().siteCeiling == 0 && mark.state().sequence <= 1;
}

void removeDatabase(const std::string& path) {
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(path + suffix, ignored);
}

/// The mark comes first, with commit 0: a start that is cut off between it and the database migrates again.
Status migrate(const std::string& path, const SqliteJournalOptions& options) {
  const std::string markPath = markPathOf(path);
  const auto mark = SessionMark::open(markPath);
  if (!mark) return Error{mark.error().message + kAdvice};
  if (*mark && (*mark)->state().sequence > 0)
    return Error{path + ": rolled back: schema version 1, but " + markPath + " is of a later one" + kAdvice};
  const Result<Version1> found = SessionDatabase::readVersion1(path);
  if (!found) return Error{found.error().message + kAdvice};
  const JournalContents& contents = found->contents;
  DatabaseHead head;
  head.session = randomDigest();
  head.scene = found->scene;
  head.sessionTime = contents.sessionTime;
  Reach reach;
  std::vector<JournalRecord> records;
  records.insert(records.end(), contents.parts.begin(), contents.parts.end());
  records.insert(records.end(), contents.sites.begin(), contents.sites.end());
  records.insert(records.end(), contents.nonces.begin(), contents.nonces.end());
  for (const JournalRecord& record : records) reach.include(record);
  const MarkState begun{head.session, options.key, reach.epochBlock(), reach.siteBlock(), 0, {}};
  if (auto made = SessionMark::create(markPath, begun); !made) return made.error();
  return SessionDatabase::migrate(path, head, records);
}

/// Migrates a database of schema version 1, and refuses one of a version that is not known.
Status bringUpToDate(const std::string& path, const SqliteJournalOptions& options) {
  const Result<int> version = SessionDatabase::versionOf(path);
  if (!version) return {};  // damaged: whoever opens it says so
  if (*version > SessionDatabase::kSchemaVersion)
    return Error{path + ": schema version " + std::to_string(*version) +
                 " of a newer tandem-server, this one knows version " +
                 std::to_string(SessionDatabase::kSchemaVersion)};
  return *version == 1 ? migrate(path, options) : Status{};
}

Result<SessionDatabase> openOrBegin(const std::string& path, const SqliteJournalOptions& options) {
  const std::string markPath = markPathOf(path);
  const bool there = std::filesystem::exists(path);
  if (there)
    if (Status current = bringUpToDate(path, options); !current) return current.error();
  auto mark = SessionMark::open(markPath);
  if (!mark) return Error{mark.error().message + kAdvice};
  if (!*mark && !there && !options.mustExist) return begin(path, options);
  if (!*mark && !there)
    return Error{path + " and " + markPath + ": missing, though a session was kept here" + kAdvice};
  if (!*mark && std::filesystem::file_size(path) == 0 && !options.mustExist) {
    removeDatabase(path);
    return begin(path, options);
  }
  const bool untold = *mark && !options.mustExist && isUntold(**mark);
  if (!there && untold) return begin(path, options);
  if (!there)
    return Error{path + ": missing, though " + markPath + " says that a session was kept" + kAdvice};
  if (!*mark) return Error{markPath + ": missing, so how far epochs had come is not known" + kAdvice};
  if ((*mark)->state().key != options.key && !untold)
    return Error{markPath + ": belongs to a session of another server" + kAdvice};
  if (untold && ((*mark)->state().key != options.key || !SessionDatabase::open(path, options.maxPages))) {
    removeDatabase(path);
    return begin(path, options);
  }
  auto database = SessionDatabase::open(path, options.maxPages);
  if (!database) return Error{database.error().message + kAdvice};
  if (Status whole = checkAgainst(**mark, database->head()); !whole)
    return Error{path + ": " + whole.error().message + kAdvice};
  return database;
}

}  // namespace

Result<std::unique_ptr<SqliteJournal>> SqliteJournal::open(const std::string& path,
                                                           const SqliteJournalOptions& options) {
  Result<SessionDatabase> database = openOrBegin(path, options);
  if (!database) return database.error();
  if (Status ready = database->takeScene(options.sceneHash); !ready)
    return Error{path + ": " + ready.error().message};
  auto mark = SessionMark::open(markPathOf(path));
  if (!mark) return mark.error();
  if (!*mark) return Error{markPathOf(path) + ": was removed"};
  auto state = std::make_unique<State>(path, options, std::move(**mark), std::move(*database));
  if (Status started = state->start(); !started) return started.error();
  return std::unique_ptr<SqliteJournal>(new SqliteJournal(std::move(state)));
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
  if (state_->failure.empty()) (void)state_->mark.reserve(0, 0);  // syncs it
}

void SqliteJournal::onProgress(std::function<void()> callback) {
  const std::lock_guard lock(state_->mutex);
  state_->callback = std::move(callback);
}

JournalContents SqliteJournal::contents() const { return state_->contents; }

std::uint64_t SqliteJournal::append(const JournalRecord& record) {
  ++state_->appended;
  {
    const std::lock_guard lock(state_->mutex);
    state_->queue.push_back(record);
  }
  state_->wanted.notify_one();
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
