#include "sync/transport/crowd.h"

#include <algorithm>
#include <limits>

#include "assets/base/assert.h"

namespace tandem::sync {

Crowd::Rank Crowd::rankOf(Network network, const std::set<VisitorId>& members) const {
  const std::size_t size = std::max(members.size(), handful_);
  return {std::numeric_limits<std::size_t>::max() - size, *members.begin(), network};
}

void Crowd::add(VisitorId visitor, Network network) {
  const bool isNew = networkOf_.emplace(visitor, network).second;
  ASSERT(isNew);
  std::set<VisitorId>& members = members_[network];
  if (!members.empty()) order_.erase(rankOf(network, members));
  members.insert(visitor);
  order_.insert(rankOf(network, members));
}

void Crowd::remove(VisitorId visitor) {
  const auto found = networkOf_.find(visitor);
  if (found == networkOf_.end()) return;
  const Network network = found->second;
  std::set<VisitorId>& members = members_[network];
  order_.erase(rankOf(network, members));
  members.erase(visitor);
  if (members.empty())
    members_.erase(network);
  else
    order_.insert(rankOf(network, members));
  networkOf_.erase(found);
}

VisitorId Crowd::first() const {
  ASSERT(!order_.empty());
  return std::get<1>(*order_.begin());
}

}  // namespace tandem::sync
