#pragma once

// A journal on virtual time: what was appended becomes durable after a delay, and a crash loses what was not.
// Lives outside the simulated server, as a disk does. Its writes fail by request; all other faults of a disk
// are those of FaultyJournal (client/simulation/faulty_journal.h).

#include <cstdint>
#include <deque>
#include <string>

#include "server/journal/journal.h"

namespace tandem::server {

class MemoryJournal : public Journal {
 public:
  explicit MemoryJournal(sync::Micros syncDelay = sync::kMillisecond) : syncDelay_(syncDelay) {}

  void advanceTo(sync::Micros now);
  /// The server died: what was not yet durable is gone.
  void crash();

  /// From now on nothing becomes durable, as on a full disk.
  void fail(const std::string& reason) { failure_ = reason; }
  /// The disk is well again.
  void heal();

  JournalContents contents() const override;
  std::uint64_t append(const JournalRecord& record) override;
  void noteTime(sync::Micros sessionTime) override;
  std::uint64_t durableUpTo() override;
  std::string failure() const override { return failure_; }

 private:
  struct Pending {
    sync::Micros durableAt = 0;
    JournalRecord record;
  };

  sync::Micros syncDelay_, now_ = 0;
  std::deque<Pending> pending_;
  std::uint64_t appended_ = 0;
  std::string failure_;
  JournalContents contents_;
};

}  // namespace tandem::server
