#include "sync/transport/recent_use.h"

#include <algorithm>
#include <cmath>

namespace tandem::sync {

double RecentUse::order(std::uint64_t key) const {
  const auto found = entries_.find(key);
  return found == entries_.end() ? kNone : found->second.order;
}

double RecentUse::count(std::uint64_t key, Micros now) const {
  return std::exp(order(key) - static_cast<double>(now) / static_cast<double>(memory_));
}

void RecentUse::add(std::uint64_t key, Micros now) {
  const auto found = entries_.find(key);
  if (found == entries_.end() && entries_.size() == kMaxKeys) {
    entries_.erase(oldestFirst_.front());
    oldestFirst_.pop_front();
  }
  if (found != entries_.end()) oldestFirst_.erase(found->second.place);
  Entry& entry = entries_[key];
  entry.place = oldestFirst_.insert(oldestFirst_.end(), key);
  const double use = static_cast<double>(now) / static_cast<double>(memory_);
  const double more = std::max(entry.order, use), less = std::min(entry.order, use);
  entry.order = more + std::log1p(std::exp(less - more));
}

void RecentUse::takeBack(std::uint64_t key, Micros at) {
  constexpr double kRounding = 1e-9;
  const auto found = entries_.find(key);
  if (found == entries_.end()) return;
  const double share = std::exp(static_cast<double>(at) / static_cast<double>(memory_) - found->second.order);
  if (share < 1.0 - kRounding) {
    found->second.order += std::log1p(-share);
    return;
  }
  oldestFirst_.erase(found->second.place);
  entries_.erase(found);
}

}  // namespace tandem::sync
