#pragma once

// What an instructor may order: take a part away from its owner, put all free parts back to where the scene
// has them.
//
// 1. A command repeated by (site, request id) gets the same answer again (S7), among the last 16 of its site.
// 2. One reset runs at a time, over as many steps as it needs, and is answered when it is done.

#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "server/part_service.h"
#include "server/peers.h"
#include "server/publisher.h"
#include "server/session_context.h"
#include "server/sites.h"

namespace tandem::server {

class InstructorCommands {
 public:
  InstructorCommands(SessionContext& context, Peers& peers, const Sites& sites, Publisher& publisher,
                     PartService& parts);

  void onRevoke(const Peer& peer, const sync::Revoke& request);
  void onReset(const Peer& peer, const sync::ResetParts& request);
  /// Puts back the next few parts of the reset that is under way, if there is one.
  void continueReset();
  bool resetting() const { return reset_.has_value(); }

 private:
  struct Reset {
    std::vector<PartId> left;  // to be put back, from the back
    SiteId site = kNoSite;
    sync::RequestId request = 0;
  };

  /// Whether the command is new and allowed; if not, it has been answered or will be.
  bool mayCommand(const Peer& peer, sync::RequestId request);
  void audit(AuditEvent event, const Peer& peer, const std::string& detail);
  void answer(SiteId site, sync::RequestId request, bool done, const std::string& reason);

  SessionContext& context_;
  Peers& peers_;
  const Sites& sites_;
  Publisher& publisher_;
  PartService& parts_;
  std::optional<Reset> reset_;
  std::map<SiteId, std::deque<sync::CommandReply>> answers_;  // to the latest commands of each site
};

}  // namespace tandem::server
