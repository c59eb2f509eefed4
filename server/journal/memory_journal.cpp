#include "server/journal/memory_journal.h"

#include <algorithm>

namespace tandem::server {

void MemoryJournal::advanceTo(sync::Micros now) {
  now_ = std::max(now_, now);
  if (!failure_.empty()) return;
  while (!pending_.empty() && pending_.front().durableAt <= now_) {
    server::apply(contents_, pending_.front().record);
    pending_.pop_front();
  }
}

void MemoryJournal::heal() {
  failure_.clear();
  // What was appended before or meanwhile is written before anything else is reported.
  for (Pending& pending : pending_) pending.durableAt = std::min(pending.durableAt, now_);
  advanceTo(now_);
}

void MemoryJournal::crash() {
  // No site has learned of the lost records; the next server counts on from the last that is safe.
  appended_ -= pending_.size();
  pending_.clear();
}

JournalContents MemoryJournal::contents() const { return contents_; }

std::uint64_t MemoryJournal::append(const JournalRecord& record) {
  pending_.push_back({now_ + syncDelay_, record});
  return ++appended_;
}

void MemoryJournal::noteTime(sync::Micros sessionTime) {
  contents_.sessionTime = std::max(contents_.sessionTime, sessionTime);
}

std::uint64_t MemoryJournal::durableUpTo() {
  advanceTo(now_);
  return appended_ - pending_.size();
}

}  // namespace tandem::server
