#include "sync/replica/co_holder_lists.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"
#include "sync/wire/limits.h"

namespace tandem::sync {

void CoHolderLists::changed(PartId part) {
  ++parts_[part].version;
  if (std::find(changed_.begin(), changed_.end(), part) == changed_.end()) changed_.push_back(part);
}

bool CoHolderLists::add(PartId part, SiteId site, Micros now) {
  ASSERT(part < parts_.size() && site != kNoSite);
  Site& entry = sites_[site];
  entry.lastRenewed = now;
  if (!entry.parts.insert(part).second) return false;
  parts_[part].sites.push_back(site);
  changed(part);
  return true;
}

bool CoHolderLists::remove(PartId part, SiteId site) {
  ASSERT(part < parts_.size());
  if (std::erase(parts_[part].sites, site) == 0) return false;
  const std::size_t erased = sites_[site].parts.erase(part);
  ASSERT(erased == 1);
  changed(part);
  return true;
}

void CoHolderLists::removeAll(PartId part) {
  ASSERT(part < parts_.size());
  while (!parts_[part].sites.empty()) remove(part, parts_[part].sites.back());
}

void CoHolderLists::removeFromAll(SiteId site) {
  const auto found = sites_.find(site);
  if (found == sites_.end()) return;
  const std::set<PartId> parts = found->second.parts;
  for (const PartId part : parts) remove(part, site);
  ASSERT(found->second.parts.empty());
}

void CoHolderLists::removeSilent(Micros now, Micros limit) {
  for (const auto& [site, entry] : sites_)
    if (now - entry.lastRenewed >= limit) removeFromAll(site);
}

void CoHolderLists::renew(SiteId site, Micros now) {
  if (const auto found = sites_.find(site); found != sites_.end()) found->second.lastRenewed = now;
}

Micros CoHolderLists::lastRenewed(SiteId site) const {
  const auto found = sites_.find(site);
  ASSERT(found != sites_.end());
  return found->second.lastRenewed;
}

void CoHolderLists::forget(SiteId site) {
  removeFromAll(site);
  sites_.erase(site);
}

bool CoHolderLists::contains(PartId part, SiteId site) const {
  ASSERT(part < parts_.size());
  const std::vector<SiteId>& sites = parts_[part].sites;
  return std::find(sites.begin(), sites.end(), site) != sites.end();
}

bool CoHolderLists::full(PartId part, SiteId site) const {
  return parts_[part].sites.size() >= kMaxCoHolders && !contains(part, site);
}

std::optional<SiteId> CoHolderLists::longest(PartId part) const {
  ASSERT(part < parts_.size());
  if (parts_[part].sites.empty()) return std::nullopt;
  return parts_[part].sites.front();
}

CoHolderRecord CoHolderLists::record(PartId part, Epoch epoch) const {
  ASSERT(part < parts_.size());
  return {part, epoch, parts_[part].version, parts_[part].sites};
}

std::vector<PartId> CoHolderLists::drainChanged() { return std::exchange(changed_, {}); }

}  // namespace tandem::sync
