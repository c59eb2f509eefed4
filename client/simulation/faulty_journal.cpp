#include "client/simulation/faulty_journal.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::client {

using sync::Micros;

void FaultyJournal::keep(const server::JournalRecord& record) {
  server::apply(contents_, record);
  if (const auto* part = std::get_if<sync::PartRecord>(&record)) {
    Epoch& highest = highest_[part->part];
    highest = std::max(highest, part->epoch);
  } else if (const auto* site = std::get_if<server::SiteRecord>(&record)) {
    if (site->info.site > lastSite_.info.site) lastSite_ = *site;
  }
}

void FaultyJournal::setLying(bool lying) {
  if (lying && !lying_) onDisk_ = contents_;
  lying_ = lying;
}

void FaultyJournal::advanceTo(Micros now) {
  now_ = std::max(now_, now);
  if (failing_ && failed_) return;
  // A journal that is well again has first written everything that was appended.
  const bool writesAll = std::exchange(failed_, false);
  while (!pending_.empty() && (writesAll || pending_.front().durableAt <= now_)) {
    if (failing_) {
      failed_ = true;
      return;
    }
    keep(pending_.front().record);
    pending_.pop_front();
  }
}

Micros FaultyJournal::nextDurable(Micros never) const {
  return pending_.empty() || (failing_ && failed_) ? never : pending_.front().durableAt;
}

void FaultyJournal::rot() {
  if (contents_.parts.empty()) return;
  contents_.parts.erase(contents_.parts.begin() +
                        static_cast<std::ptrdiff_t>(random_.draw() % contents_.parts.size()));
  damaged_ = true;
}

void FaultyJournal::heal() {
  failing_ = tearing_ = lying_ = false;  // in time, the disk has written what it had said it had
  delay_ = sync::kMillisecond;
}

void FaultyJournal::crash() {
  // A record that is half on the disk is whole or absent to who reads it by its checksum.
  if (tearing_ && !pending_.empty() && !failed_ && random_.draw() % 2 == 0) {
    keep(pending_.front().record);
    pending_.pop_front();
  }
  if (lying_) {
    onDisk_.sessionTime = contents_.sessionTime;
    contents_ = onDisk_;
    damaged_ = true;
  }
  // No site has learned of the lost records; the next server counts on from the last that is safe.
  appended_ -= pending_.size();
  pending_.clear();
  failed_ = false;
}

bool FaultyJournal::restart() {
  const bool recovers = std::exchange(damaged_, false);
  if (recovers) {
    // Numbers of sites are not given again either. The server's key changes, so that their tickets are void.
    if (lastSite_.info.site != kNoSite) {
      server::SiteRecord last = lastSite_;
      last.left = true;
      keep(last);
    }
    // What was told of a part may be newer than what is left of it, so that every epoch goes beyond.
    for (const auto& entry : highest_) {
      const PartId part = entry.first;
      sync::PartRecord record;
      const auto left = std::find_if(contents_.parts.begin(), contents_.parts.end(),
                                     [&](const auto& each) { return each.part == part; });
      if (left != contents_.parts.end()) record = *left;
      record.part = part;
      record.owner = kNoSite;
      record.epoch = entry.second + 1;
      keep(record);
    }
  }
  return recovers;
}

std::uint64_t FaultyJournal::append(const server::JournalRecord& record) {
  const Micros last = pending_.empty() ? 0 : pending_.back().durableAt;
  pending_.push_back({std::max(last, now_ + delay_), record});
  return ++appended_;
}

void FaultyJournal::noteTime(Micros sessionTime) {
  contents_.sessionTime = std::max(contents_.sessionTime, sessionTime);
}

std::uint64_t FaultyJournal::durableUpTo() {
  advanceTo(now_);
  return appended_ - pending_.size();
}

}  // namespace tandem::client
