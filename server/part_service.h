#pragma once

// The parts of the session: grabs, releases and engagements, leases, and the poses that the journal keeps.
// The rules themselves are sync::OwnershipTable; this class writes each decision to the journal, answers, and
// publishes it.
//
// 1. Every change of an owner is kept before its answer is queued, and answered before it is published.
// 2. While the journal cannot be written, every request is denied as `recovering`.

#include <optional>
#include <vector>

#include "assets/scene/scene.h"
#include "server/publisher.h"
#include "server/session_context.h"
#include "server/sites.h"
#include "sync/replica/lease_rules.h"
#include "sync/replica/ownership_table.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/state_update.h"

namespace tandem::server {

class PartService {
 public:
  /// All that is referred to outlives this.
  PartService(const assets::Scene& scene, const sync::LeaseRules& lease, SessionContext& context,
              Publisher& publisher, const Sites& sites);

  /// Takes over the journal's parts; records of parts that the scene does not have are left out.
  void restore(const std::vector<sync::PartRecord>& records, Epoch floor);
  /// The journal is well again: grants that were answered with a denial are taken back, and what could not be
  /// published is published.
  void resume(const Abandoned& abandoned);

  void onGrab(const Peer& peer, const sync::Grab& request);
  void onReclaim(const Peer& peer, const sync::Reclaim& request);
  void onRelease(const Peer& peer, const sync::Release& request);
  void onEngage(const Peer& peer, const sync::Engage& request);
  void onDisengage(const Peer& peer, const sync::Disengage& request);
  /// Publishes the co-holders of parts where they have changed since the last call, behind the parts' own
  /// records.
  void publishCoHolders();

  /// Takes a part away from its owner. False if nobody owns it.
  bool revoke(PartId part, SiteId by);
  /// Puts a part back to its pose in the scene, unless somebody owns it.
  void putBack(PartId part);
  /// The site left for good: its parts are free, or another's.
  void leave(SiteId site);

  /// Frees the parts whose lease has run out (L2).
  void expireLeases();
  /// A ping of the site arrived: its leases run anew.
  void renew(SiteId site) { table_.renew(site, context_.now()); }
  /// Whether this state may be relayed (S2); if so it is the part's newest pose, which keepPoses() will keep.
  bool accept(SiteId site, const sync::PartState& state);
  /// Keeps the newest poses of owned parts, so that a crash of the server and of an owner together loses
  /// little.
  void keepPoses();

  const sync::OwnershipTable& table() const { return table_; }
  /// The part's name in the scene. The part must exist.
  const std::string& nameOf(PartId part) const;
  /// A site as the log names it.
  std::string siteName(SiteId site) const { return sites_.nameOf(site); }
  std::size_t count() const { return scene_.parts.size(); }

 private:
  /// Where a site says that it leaves or still has a part; the newest pose that is known if that lies outside
  /// the wire's frame, so that no site can put a part where nobody can reach it.
  Pose poseOf(PartId part, const Pose& worldFromPart);
  void answerGrab(const Peer& peer, const sync::OwnershipTable::Decision& decision);
  /// Keeps a part's new record; its pose is then no newer than the journal's.
  void keep(const sync::PartRecord& record);
  /// Keeps a part's new record, then publishes it.
  void change(const sync::PartRecord& record);
  void freed(const std::vector<sync::PartRecord>& records, const char* why);
  sync::PartRecord recordWithoutOwner(PartId part) const;

  const assets::Scene& scene_;
  sync::WireFrame frame_;
  SessionContext& context_;
  Publisher& publisher_;
  const Sites& sites_;
  sync::OwnershipTable table_;
  std::vector<PartId> movedParts_;  // owned parts whose pose is newer than the journal's
  std::vector<bool> moved_;  // by part; also cleared by a newer record, with the part left in movedParts_
};

}  // namespace tandem::server
