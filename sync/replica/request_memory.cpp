#include "sync/replica/request_memory.h"

#include "assets/base/assert.h"

namespace tandem::sync {

const RequestMemory::Answer* RequestMemory::find(SiteId site, const Request& request) const {
  const auto known = sites_.find(site);
  if (known == sites_.end()) return nullptr;
  for (const Entry& entry : known->second)
    if (entry.request == request) return &entry.answer;
  return nullptr;
}

void RequestMemory::remember(SiteId site, const Request& request, const Answer& answer) {
  ASSERT(find(site, request) == nullptr);
  std::deque<Entry>& entries = sites_[site];
  if (entries.size() == kPerSite) entries.pop_front();
  entries.push_back({request, answer});
  ASSERT(entries.size() <= kPerSite);
}

}  // namespace tandem::sync
