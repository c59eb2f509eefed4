#pragma once

// A journal on virtual time: what was appended becomes durable after a delay, and a crash loses what was not.
// Lives outside the simulated server, as a disk does, and has a disk's faults by request:
//
// 1. fail() and heal(): writes fail for a while; what was appended is written when they succeed again.
// 2. tear(): a crash keeps the first few of the records that were on their way, as a torn batch does.
// 3. lie(): records are reported as durable at once, and the next crash loses those that were not.
// 4. rot(): bits of the disk change while no server runs.
//
// Besides, it keeps a mark, as SqliteJournal does: how far it was ever reported as durable, and the highest
// epoch in it. A start must ask damage() first, and refuse or recover() if there is some.

#include <cstdint>
#include <deque>
#include <string>

#include "server/journal.h"

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
  /// At the next crash this many of the records that are on their way reach the disk all the same.
  void tear(std::size_t kept) { torn_ = kept; }
  /// Whether the disk reports what it has not written. A crash then loses what is not on it.
  void lie(bool lying) { lying_ = lying; }
  /// Changes the record of a part, or of any if it has none, on the disk.
  void rot(PartId part);

  /// Why a start must not trust the records; empty if they are sound.
  std::string damage() const;
  /// As tandem-server --recover: keeps the poses of sound records, frees every part in an epoch beyond the
  /// mark, and begins a new generation of tokens and tickets.
  void recover();
  /// How often it was recovered; credentials of an earlier generation are void.
  std::uint32_t generation() const { return generation_; }

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
  void write(const JournalRecord& record);

  sync::Micros syncDelay_, now_ = 0;
  std::deque<Pending> pending_;
  std::uint64_t appended_ = 0;
  std::string failure_;
  JournalContents contents_;
  std::size_t torn_ = 0;
  bool lying_ = false;
  std::uint64_t told_ = 0;   // of the mark: the last record reported as durable
  Epoch highest_ = 0;        // of the mark: no epoch beyond it was told
  SiteId lastSite_ = 0;      // of the mark
  PartId rotten_ = kNoPart;  // a part whose record has changed on the disk
  std::uint32_t generation_ = 0;
};

}  // namespace tandem::server
