#include "server/sites.h"

#include <algorithm>

#include "assets/base/assert.h"
#include "sync/wire/limits.h"

namespace tandem::server {
namespace {

constexpr sync::Micros kListedAfterLoss = 60 * sync::kSecond;  // how long the others still see a lost site
constexpr SiteId kMaxLastSite = 0xfffe;

}  // namespace

void Sites::restore(std::span<const SiteRecord> records, SiteId last, sync::Micros now) {
  ASSERT(known_.empty());
  next_ = static_cast<SiteId>(std::min(last, kMaxLastSite) + 1);
  for (const auto& record : records) {
    KnownSite& site = known_[record.info.site];
    site.info = record.info;
    site.info.connected = false;
    site.left = record.left;
    site.listed = !record.left;
    site.disconnectedAt = now;
    next_ = std::max<SiteId>(next_, static_cast<SiteId>(record.info.site + 1));
  }
}

bool Sites::exhausted() const { return next_ > kMaxLastSite; }

KnownSite& Sites::add(sync::Role role) {
  ASSERT(!exhausted());
  ASSERT(!known_.contains(next_));
  KnownSite& site = known_[next_];
  site.info.site = next_++;
  site.info.role = role;
  return site;
}

KnownSite* Sites::find(SiteId site) {
  const auto at = known_.find(site);
  return at == known_.end() ? nullptr : &at->second;
}

KnownSite& Sites::at(SiteId site) {
  const auto at = known_.find(site);
  ASSERT(at != known_.end());
  return at->second;
}

std::string Sites::nameOf(SiteId site) const {
  const auto at = known_.find(site);
  return "site " + std::to_string(site) + (at == known_.end() ? "" : " \"" + at->second.info.name + "\"");
}

sync::SiteColour Sites::freeColour(SiteId except) const {
  const auto uses = [&](const sync::SiteColour& colour) {
    return std::count_if(known_.begin(), known_.end(), [&](const auto& entry) {
      return entry.first != except && entry.second.listed && entry.second.info.colour == colour;
    });
  };
  return *std::min_element(sync::kSiteColours.begin(), sync::kSiteColours.end(),
                           [&](const auto& a, const auto& b) { return uses(a) < uses(b); });
}

std::vector<SiteId> Sites::relist(sync::Micros now) {
  std::vector<SiteId> unlisted;
  const auto unlist = [&](KnownSite& site) {
    site.listed = false;
    unlisted.push_back(site.info.site);
  };
  std::vector<KnownSite*> lost;
  std::size_t shown = 0;
  for (auto& [id, site] : known_) {
    if (!site.listed) continue;
    if (!site.info.connected && now - site.disconnectedAt > kListedAfterLoss) {
      unlist(site);
      continue;
    }
    ++shown;
    if (!site.info.connected) lost.push_back(&site);
  }
  std::stable_sort(lost.begin(), lost.end(),
                   [](const auto* a, const auto* b) { return a->disconnectedAt < b->disconnectedAt; });
  for (std::size_t i = 0; shown > sync::kMaxSites && i < lost.size(); ++i, --shown) unlist(*lost[i]);
  listed_.clear();
  for (const auto& [id, site] : known_)
    if (site.listed) listed_.push_back(site.info);
  return unlisted;
}

}  // namespace tandem::server
