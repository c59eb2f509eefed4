#include "server/memory_journal.h"

#include <algorithm>
#include <string>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::server {

void MemoryJournal::write(const JournalRecord& record) { server::apply(contents_, record); }

void MemoryJournal::advanceTo(sync::Micros now) {
  now_ = std::max(now_, now);
  if (!failure_.empty()) return;
  while (!pending_.empty() && pending_.front().durableAt <= now_) {
    write(pending_.front().record);
    pending_.pop_front();
  }
  if (!lying_) told_ = std::max(told_, appended_ - pending_.size());
}

void MemoryJournal::heal() {
  failure_.clear();
  // What was appended before or meanwhile is written before anything else is reported.
  for (Pending& pending : pending_) pending.durableAt = std::min(pending.durableAt, now_);
  advanceTo(now_);
}

void MemoryJournal::crash() {
  for (std::size_t kept = std::exchange(torn_, 0); kept > 0 && !pending_.empty(); --kept) {
    write(pending_.front().record);
    pending_.pop_front();
  }
  // No site has learned of the lost records unless the disk lied; the next server counts on from the last
  // that is safe.
  appended_ -= pending_.size();
  pending_.clear();
}

void MemoryJournal::rot(PartId part) {
  if (contents_.parts.empty()) return;
  const auto has = [&](const sync::PartRecord& record) { return record.part == part; };
  const auto at = std::find_if(contents_.parts.begin(), contents_.parts.end(), has);
  rotten_ = at == contents_.parts.end() ? contents_.parts.front().part : at->part;
}

std::string MemoryJournal::damage() const {
  if (rotten_ != kNoPart) return "record of part " + std::to_string(rotten_) + ": its checksum is wrong";
  if (appended_ < told_)
    return "ends at record " + std::to_string(appended_) + ", but record " + std::to_string(told_) +
           " was reported as durable";
  return {};
}

void MemoryJournal::recover() {
  ASSERT(pending_.empty());
  std::erase_if(contents_.parts, [&](const sync::PartRecord& record) { return record.part == rotten_; });
  contents_.epochFloor = std::max(contents_.epochFloor, highest_);
  contents_.lastSite = std::max(contents_.lastSite, lastSite_);
  for (sync::PartRecord& record : contents_.parts) {
    record.owner = kNoSite;
    record.epoch = contents_.epochFloor + 1;
  }
  highest_ = contents_.epochFloor + 1;
  rotten_ = kNoPart;
  told_ = appended_;
  ++generation_;
}

JournalContents MemoryJournal::contents() const { return contents_; }

std::uint64_t MemoryJournal::append(const JournalRecord& record) {
  if (const auto* part = std::get_if<sync::PartRecord>(&record)) highest_ = std::max(highest_, part->epoch);
  if (const auto* site = std::get_if<SiteRecord>(&record)) lastSite_ = std::max(lastSite_, site->info.site);
  pending_.push_back({now_ + syncDelay_, record});
  return ++appended_;
}

void MemoryJournal::noteTime(sync::Micros sessionTime) {
  contents_.sessionTime = std::max(contents_.sessionTime, sessionTime);
}

std::uint64_t MemoryJournal::durableUpTo() {
  advanceTo(now_);
  if (lying_ && failure_.empty()) told_ = appended_;
  return std::max(told_, appended_ - pending_.size());
}

}  // namespace tandem::server
