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
  connections_[peer.serial] = connection;
  Peer& added = peers_[connection];
  added = peer;
  return added;
}

void Peers::erase(sync::ConnectionId connection) {
  const auto at = peers_.find(connection);
  if (at == peers_.end()) return;
  connections_.erase(at->second.serial);
  peers_.erase(at);
  ++changes_;
}

void Peers::clear() {
  peers_.clear();
  connections_.clear();
  ++changes_;
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
  const auto at = connections_.find(serial);
  return at == connections_.end() ? nullptr : find(at->second);
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

}  // namespace tandem::server
