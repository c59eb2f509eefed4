#pragma once

// The co-holders of every part, as the server keeps them: the sites that simulate a part beside its owner.
//
// 1. The list of a part has a version, which grows with every change of the list (S5).
// 2. A site stays on its lists only as long as its pings arrive; removeSilent() takes it off them.

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "sync/wire/ownership_messages.h"
#include "sync/wire/time.h"

namespace tandem::sync {

class CoHolderLists {
 public:
  explicit CoHolderLists(std::size_t partCount) : parts_(partCount) {}

  /// Appends the site to the list of the part; false if it is on it already. Counts as a ping of the site.
  bool add(PartId part, SiteId site, Micros now);
  /// False if the site is not on the list.
  bool remove(PartId part, SiteId site);
  void removeAll(PartId part);
  void removeFromAll(SiteId site);
  /// Removes the sites whose last ping arrived `limit` ago or earlier.
  void removeSilent(Micros now, Micros limit);

  /// A ping of the site arrived.
  void renew(SiteId site, Micros now);
  /// When the last ping of a site arrived that has been a co-holder.
  Micros lastRenewed(SiteId site) const;
  /// The site left for good.
  void forget(SiteId site);

  bool contains(PartId part, SiteId site) const;
  /// The part has kMaxCoHolders, and the site is none of them.
  bool full(PartId part, SiteId site) const;
  /// The site that has been on the list for longest; nothing if the list is empty.
  std::optional<SiteId> longest(PartId part) const;
  /// The list of a part whose ownership is in this epoch.
  CoHolderRecord record(PartId part, Epoch epoch) const;
  /// The parts whose lists have changed since the last call, in the order of their first changes.
  std::vector<PartId> drainChanged();

 private:
  struct List {
    std::uint32_t version = 0;
    std::vector<SiteId> sites;  // the longest co-holder first
  };
  struct Site {
    std::set<PartId> parts;  // ordered, so that changes have the same order in every run
    Micros lastRenewed = 0;
  };
  void changed(PartId part);

  std::vector<List> parts_;
  std::map<SiteId, Site> sites_;
  std::vector<PartId> changed_;
};

}  // namespace tandem::sync
