#pragma once

// The journal on a disk: SQLite in WAL mode with synchronous=FULL, written by a thread of its own, and a mark
// beside it (session_mark.h).
//
// 1. append() and noteTime() only queue; the writer commits everything that is queued as one transaction
//    (group commit), so that many grants cost one fsync, and the network thread never waits for a disk.
// 2. A record counts as durable only after COMMIT has returned and the mark has been noted.
// 3. A start verifies all checksums and the chain, and that the database ends where the mark says. What is
//    damaged, rolled back, missing, of another session or another scene is refused with its place.
// 4. A write that fails, or a file that was removed or replaced, stops the journal: nothing becomes durable.
//    Twice a second it opens its files anew and verifies them; when they are well it writes what was pending
//    and goes on.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "server/journal/journal.h"
#include "server/journal/record_digest.h"

namespace tandem::server {

struct SqliteJournalOptions {
  std::string sceneHash;                  // hexadecimal; a journal of another scene is refused
  std::uint32_t maxPages = 0;             // of the database; 0 = no limit beyond SQLite's
  Digest key{};                           // of the server's identity; a mark with another one is refused
  bool mustExist = false;                 // a session was kept here: do not begin a new one
  std::vector<std::string> watched = {};  // other files that must stay what they are while it is open
};

/// The mark's path, beside the database.
std::string markPathOf(const std::string& databasePath);

class SqliteJournal : public Journal {
 public:
  /// Opens or creates the database file and its mark.
  static Result<std::unique_ptr<SqliteJournal>> open(const std::string& path,
                                                     const SqliteJournalOptions& options);
  /// Writes what is queued, then closes.
  ~SqliteJournal() override;

  /// Called from the writer's thread whenever durableUpTo() has grown, or the journal has failed or is well
  /// again. Set it before the first append; it must stay callable until the journal is destroyed.
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
