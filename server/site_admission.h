#pragma once

// Who may come in, in which role and in which place, and who is dropped: hello, resume, refusals, goodbye,
// silence.
//
// 1. A join token works once: its nonce is in the journal before the Welcome leaves.
// 2. A site's newest connection replaces the older one.
// 3. A lost connection is no goodbye: the site may come back with its ticket and finds its parts, until their
//    leases run out.

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

#include "server/part_service.h"
#include "server/peers.h"
#include "server/publisher.h"
#include "server/scene_transfer.h"
#include "server/session_config.h"
#include "server/session_context.h"
#include "server/sites.h"
#include "server/state_relay.h"
#include "sync/transport/transport.h"

namespace tandem::server {

class SiteAdmission {
 public:
  /// What admission works on; all of it outlives the admission.
  struct Ground {
    const SessionConfig& config;
    SessionContext& context;
    sync::Transport& transport;
    Peers& peers;
    Sites& sites;
    Publisher& publisher;
    PartService& parts;
    StateRelay& relay;
    const SceneTransfer& scene;
  };
  explicit SiteAdmission(const Ground& ground);

  void restore(const std::vector<UsedNonce>& nonces);

  /// A connection is new; it is closed if too many have sent no Hello yet.
  void onConnected(sync::ConnectionId connection);
  /// Admits or refuses the site. `peer` is gone if it was refused.
  void onHello(Peer& peer, const sync::Hello& hello);
  /// The site leaves for good. `peer` is gone afterwards.
  void onGoodbye(Peer& peer);
  /// Sends the reason and closes the connection. `peer` is gone afterwards.
  void refuse(Peer& peer, sync::Refusal refusal, const std::string& reason);
  /// The connection is over; the site may come back. Nothing happens if the connection is not there.
  void onLost(sync::ConnectionId connection, const std::string& reason);

  /// Parts from a site for good or until it comes back with its ticket; its parts are free. A connection is
  /// told the reason.
  void remove(KnownSite& site, bool forGood, const std::string& reason);
  /// From now on the ticket of this site admits nobody.
  void voidTicket(KnownSite& site);
  /// Sends every connected site that can come back a ticket signed by the present key.
  std::size_t renewTickets();

  /// Drops silent connections, forgets sites that were lost long ago.
  void housekeeping();
  /// Brings the list of sites up to date and publishes who is off it.
  void relist();

  std::vector<sync::Role> drainUsedTokens();

 private:
  /// Why there is no place for a site of this role; nothing if there is.
  std::optional<std::string> noPlaceFor(sync::Role role) const;
  void join(Peer& peer, const sync::Hello& hello, const Ticket& ticket);
  void resume(Peer& peer, const sync::Hello& hello, const Ticket& ticket);
  void admit(Peer& peer, KnownSite& site, const sync::Hello& hello);
  std::string ticketFor(const KnownSite& site) const;
  /// The Welcome of a site; `rest` gets the records of parts that do not fit into it.
  sync::Welcome welcomeFor(const KnownSite& site, std::vector<sync::PartRecord>& rest) const;
  /// The site, which has no connection, gives up its parts and its place in the list.
  void takeOff(KnownSite& site, bool forGood);
  void dropSilent();
  /// The peer is gone afterwards, its site listed as lost.
  void disconnect(sync::ConnectionId connection, const std::string& reason);
  void audit(AuditEvent event, const Peer& peer, const std::string& detail);

  Ground ground_;
  std::unordered_set<std::string> usedNonces_;
  std::vector<sync::Role> usedTokens_;  // since the last drainUsedTokens()
};

}  // namespace tandem::server
