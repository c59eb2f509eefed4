#pragma once

// The journal of a simulated server and the disk below it, on virtual time. Lives outside the server, as a
// disk does. Its faults are those of a disk under a journal whose records have checksums and whose highest
// epochs are kept beside it: what is damaged is noticed, and a recovery raises every epoch.

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "client/simulation/split_mix.h"
#include "server/journal/journal.h"

namespace tandem::client {

class FaultyJournal : public server::Journal {
 public:
  explicit FaultyJournal(std::uint64_t seed) : random_(seed) {}

  // Faults, each until it is set back.
  void setFailing(bool failing) { failing_ = failing; }
  void setDelay(sync::Micros delay) { delay_ = delay; }
  /// A record takes longer, so that a kill finds one under way.
  void setTearing(bool tearing) {
    tearing_ = tearing;
    delay_ = tearing ? 50 * sync::kMillisecond : sync::kMillisecond;
  }
  void setLying(bool lying);
  /// A record that is on the disk cannot be read any more.
  void rot();
  /// Everything is well from now on; what was damaged stays so until the next restart().
  void heal();

  void advanceTo(sync::Micros now);
  /// When the next record becomes durable; `never` if none is under way.
  sync::Micros nextDurable(sync::Micros never) const;
  /// The server died: what was not durable is gone, or half written.
  void crash();
  /// Before the server starts: reads the disk, and recovers what was damaged. Returns whether it had to.
  bool restart();
  /// Whether the next restart() will have to recover, which a person does.
  bool damaged() const { return damaged_; }

  server::JournalContents contents() const override { return contents_; }
  std::uint64_t append(const server::JournalRecord& record) override;
  void noteTime(sync::Micros sessionTime) override;
  std::uint64_t durableUpTo() override;
  std::string failure() const override { return failed_ ? "the disk is full" : ""; }

 private:
  struct Pending {
    sync::Micros durableAt = 0;
    server::JournalRecord record;
  };
  void keep(const server::JournalRecord& record);

  SplitMix64 random_;
  sync::Micros now_ = 0, delay_ = sync::kMillisecond;
  std::deque<Pending> pending_;
  std::uint64_t appended_ = 0;
  bool failing_ = false, failed_ = false, tearing_ = false, lying_ = false, damaged_ = false;
  server::JournalContents contents_, onDisk_;  // as the server believes; as of the first lie
  std::map<PartId, Epoch> highest_;            // kept beside the journal, and so is
  server::SiteRecord lastSite_;                // the site with the highest number
};

}  // namespace tandem::client
