#pragma once

// Every site that was ever admitted to the session, and the list of those that the others see.
//
// 1. A site's number is never used again.
// 2. A site that lost its connection stays listed for a while; one that sent a Goodbye does not.

#include <map>
#include <span>
#include <string>
#include <vector>

#include "server/control_budget.h"
#include "server/journal/journal.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/site_colours.h"
#include "sync/wire/time.h"

namespace tandem::server {

struct KnownSite {
  sync::SiteInfo info;
  bool left = false;    // sent a Goodbye, or the operator said so: its ticket is void
  bool listed = false;  // the others see it
  sync::Micros disconnectedAt = 0;
  ControlBudget budget;
};

class Sites {
 public:
  /// Takes over the journal's sites as disconnected at `now`. New numbers exceed `last`, too.
  void restore(std::span<const SiteRecord> records, SiteId last, sync::Micros now);

  /// No number is left for a new site.
  bool exhausted() const;
  /// A new site with the next number. Must not be called when exhausted().
  KnownSite& add(sync::Role role);
  /// Null if no such site was ever admitted.
  KnownSite* find(SiteId site);
  /// A site that was admitted.
  KnownSite& at(SiteId site);

  const std::map<SiteId, KnownSite>& all() const { return known_; }

  /// The site's number and name, for the log.
  std::string nameOf(SiteId site) const;
  /// The first colour that the fewest of the listed sites have, `except` left out.
  sync::SiteColour freeColour(SiteId except) const;

  /// Takes off the list who has been lost for too long, then the longest lost while there are more than a
  /// Welcome can hold. Returns those that were taken off, in that order.
  std::vector<SiteId> relist(sync::Micros now);
  /// As of the last relist().
  const std::vector<sync::SiteInfo>& listed() const { return listed_; }

 private:
  std::map<SiteId, KnownSite> known_;
  std::vector<sync::SiteInfo> listed_;
  SiteId next_ = 1;
};

}  // namespace tandem::server
