#pragma once

// What the operator of the server may order from outside the session: part from a site, void its ticket, void
// all links, change the keys. Each is in the log and in the audit trail.
//
// 1. Whoever names a site names exactly one: a name that several sites have is refused with their numbers.
// 2. While the journal cannot be written nothing is ordered, because nothing could be kept.

#include <string>

#include "assets/base/result.h"
#include "server/peers.h"
#include "server/publisher.h"
#include "server/session_context.h"
#include "server/site_admission.h"
#include "server/sites.h"

namespace tandem::server {

class OperatorCommands {
 public:
  OperatorCommands(SessionContext& context, Peers& peers, Sites& sites, const Publisher& publisher,
                   SiteAdmission& admission);

  /// What was done, in words, or why nothing was; so with each command.
  Result<std::string> kick(const std::string& who, bool ban);
  Result<std::string> revokeTicket(const std::string& who);
  std::string linksRevoked();
  std::string keysRotated();
  void invited(sync::Role role);

 private:
  /// A site by its number or its name; sites that are connected go before others of the same name.
  Result<SiteId> find(const std::string& who) const;
  void audit(AuditEvent event, SiteId site, const std::string& detail);

  SessionContext& context_;
  Peers& peers_;
  Sites& sites_;
  const Publisher& publisher_;
  SiteAdmission& admission_;
};

}  // namespace tandem::server
