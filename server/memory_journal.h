#pragma once

// A journal on virtual time: what was appended becomes durable after a delay, and a crash loses what was not. Lives
// outside the simulated server, as a disk does.

#include <deque>

#include "server/journal.h"

namespace tandem::server {

class MemoryJournal : public Journal {
 public:
  explicit MemoryJournal(sync::Micros syncDelay = sync::kMillisecond) : syncDelay_(syncDelay) {}

  void advanceTo(sync::Micros now);
  /// The server died: what was not yet durable is gone.
  void crash();

  JournalContents contents() const override;
  std::uint64_t append(const JournalRecord& record) override;
  void noteTime(sync::Micros sessionTime) override;
  std::uint64_t durableUpTo() override;

 private:
  struct Pending {
    sync::Micros durableAt = 0;
    JournalRecord record;
  };
  sync::Micros syncDelay_, now_ = 0;
  std::deque<Pending> pending_;
  std::uint64_t appended_ = 0;
  JournalContents contents_;
};

}  // namespace tandem::server
