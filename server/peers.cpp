#include "server/peers.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::server {

Peer& Peers::add(sync::ConnectionId connection, sync::Micros now) {
  Peer peer;
  peer.connection = connection;
  peer.serial = nextSerial_++;
  peer.lastReceived = peer.states.allowanceAt = now;
  ASSERT(peer.serial != kRecordingOnly);
  ++changes_;
  Peer& added = peers_[connection];
  added = peer;
  return added;
}

Peer* Peers::find(sync::ConnectionId connection) {
  const auto at = peers_.find(connection);
  return at == peers_.end() ? nullptr : &at->second;
}

Peer* Peers::bySite(SiteId site) {
  for (auto& [connection, peer] : peers_)
    if (peer.site == site) return &peer;
  return nullptr;
}

Peer* Peers::bySerial(PeerSerial serial) {
  const auto at = std::find_if(peers_.begin(), peers_.end(),
                               [&](const auto& entry) { return entry.second.serial == serial; });
  return at == peers_.end() ? nullptr : &at->second;
}

std::size_t Peers::strangers() const {
  return static_cast<std::size_t>(std::count_if(
      peers_.begin(), peers_.end(), [](const auto& entry) { return entry.second.stage == Stage::hello; }));
}

RoleCounts Peers::admitted() const {
  RoleCounts counts{};
  for (const auto& [connection, peer] : peers_)
    if (peer.site != kNoSite) ++counts[static_cast<std::size_t>(peer.role)];
  return counts;
}

bool Peers::anyTransfer() const {
  return std::any_of(peers_.begin(), peers_.end(),
                     [](const auto& entry) { return entry.second.transfer.active; });
}

}  // namespace tandem::server
