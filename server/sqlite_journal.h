#pragma once

// The journal on a disk: SQLite in WAL mode with synchronous=FULL, written by a thread of its own.
//
// 1. append() and noteTime() only queue; the writer commits everything that is queued as one transaction
//    (group commit), so that many grants cost one fsync, and the network thread never waits for a disk.
// 2. A record counts as durable only after COMMIT has returned.
// 3. The first error of a write is final: nothing becomes durable after it, and failure() says why.
// 4. A database that is no journal, is damaged, or belongs to another scene is refused when it is opened.

#include <functional>
#include <memory>
#include <string>

#include "assets/base/result.h"
#include "server/journal.h"

namespace tandem::server {

struct SqliteJournalOptions {
  std::string sceneHash;       // hexadecimal; a journal of another scene is refused
  std::int64_t unixNow = 0;    // s; used tokens that expired before are forgotten
  std::uint32_t maxPages = 0;  // of the database; 0 = no limit beyond SQLite's
};

class SqliteJournal : public Journal {
 public:
  /// Opens or creates the database file.
  static Result<std::unique_ptr<SqliteJournal>> open(const std::string& path,
                                                     const SqliteJournalOptions& options);
  /// Writes what is queued, then closes.
  ~SqliteJournal() override;

  /// Called from the writer's thread whenever durableUpTo() has grown or the journal has failed. Set it
  /// before the first append; it must stay callable until the journal is destroyed.
  void onProgress(std::function<void()> callback);

  /// What it held when it was opened.
  JournalContents contents() const override;
  std::uint64_t append(const JournalRecord& record) override;
  void noteTime(sync::Micros sessionTime) override;
  std::uint64_t durableUpTo() override;
  std::string failure() const override;

 private:
  struct State;
  explicit SqliteJournal(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tandem::server
