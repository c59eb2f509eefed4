#include "server/presentations.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "assets/base/assert.h"
#include "sync/wire/wire.h"

namespace tandem::server {

using sync::Presentation;
using sync::Role;
using sync::Shares;

bool Presentations::isSound(const Presentation& shown) const {
  const auto known = [&](PartId part) { return part == kNoPart || part < partCount_; };
  const std::size_t most = (partCount_ + 7) / 8;
  const sync::Inspection& looks = shown.inspection;
  const bool noClash = looks.a == kNoPart && looks.b == kNoPart;
  if (!noClash && (looks.a >= partCount_ || looks.b >= partCount_ || looks.a == looks.b)) return false;
  if (!std::all_of(looks.marks.begin(), looks.marks.end(),
                   [&](const document::Anchor& mark) { return mark.part < partCount_; }))
    return false;
  return known(shown.selected) && known(shown.pointedAt) && shown.hidden.size() <= most &&
         shown.transparent.size() <= most &&
         std::all_of(shown.style.apart.begin(), shown.style.apart.end(),
                     [&](PartId part) { return part < partCount_; });
}

void Presentations::onPresentation(const Peer& peer, const Presentation& message) {
  ASSERT(peer.stage == Stage::ready);
  Shown& shown = shown_[peer.site];
  const bool allowed = peer.role != Role::observer && isSound(message);
  if (!shown.rate.spend(context_.now()) || !allowed) {
    ++context_.counts.droppedPresentations;
    return;
  }
  shown.newest = message;
  shown.newest.site = peer.site;
  shown.due = true;
  if (message.shares == Shares::nothing) {
    shown.stopped = false;
    if (sharer_ == peer.site) sharer_ = kNoSite;
    shown.newest.endSharing();
  } else if (shown.stopped) {
    shown.newest.endSharing();
  } else if (sharer_ != peer.site) {
    takeOver(peer.site);
  }
}

bool Presentations::mayTakeOver(SiteId from, SiteId by) const {
  const auto roleOf = [&](SiteId site) { return sites_.all().at(site).info.role; };
  return from == kNoSite || roleOf(by) == Role::instructor || roleOf(from) != Role::instructor;
}

/// Makes the site the one that shares, or ends its sharing at once.
void Presentations::takeOver(SiteId by) {
  ASSERT(by != sharer_);
  const bool granted = mayTakeOver(sharer_, by);
  const SiteId loser = granted ? std::exchange(sharer_, by) : by;
  if (loser == kNoSite) return;
  Shown& ended = shown_.at(loser);
  ended.stopped = ended.tellOwner = ended.due = true;
  ended.nextAt = 0;
  ended.newest.endSharing();
}

/// A site without a connection shows nothing.
void Presentations::endLost() {
  if (std::exchange(peerChanges_, peers_.changes()) == peers_.changes()) return;
  for (auto& [site, shown] : shown_) {
    if (shown.newest.site == kNoSite || peers_.bySite(site) != nullptr) continue;
    if (sharer_ == site) sharer_ = kNoSite;
    shown.newest = {};
    shown.newest.site = site;
    shown.due = true;
    shown.stopped = shown.tellOwner = false;
  }
}

void Presentations::flush() {
  endLost();
  const auto hasRoom = [&](const Peer& peer) {
    return transport_.controlBacklog(peer.connection) < kMaxBacklog;
  };
  for (auto& [connection, peer] : peers_) {
    if (!peer.presentationsOwed || peer.stage != Stage::ready || !hasRoom(peer)) continue;
    peer.presentationsOwed = false;
    for (const auto& [site, shown] : shown_)
      if (shown.newest.site != kNoSite && site != peer.site) send(peer, sync::encodeControl(shown.newest));
  }
  for (auto& [site, shown] : shown_) {
    if (!shown.due || context_.now() < shown.nextAt) continue;
    const std::vector<std::byte> bytes = sync::encodeControl(shown.newest);
    std::size_t ready = 0;
    for (auto& [connection, peer] : peers_) {
      if (peer.stage != Stage::ready) continue;
      ++ready;
      if (site == peer.site && !shown.tellOwner) continue;
      if (site == peer.site || hasRoom(peer))
        send(peer, bytes);
      else
        peer.presentationsOwed = true;
    }
    const double share = static_cast<double>(ready) / kPeersPerPeriod;
    shown.nextAt =
        context_.now() + static_cast<sync::Micros>(static_cast<double>(kPeriod) * std::max(1.0, share));
    shown.due = shown.tellOwner = false;
    ++context_.counts.relayedPresentations;
  }
}

void Presentations::send(const Peer& peer, std::span<const std::byte> bytes) {
  context_.counts.sent.countControl(bytes.size());
  transport_.sendControl(peer.connection, bytes);
}

}  // namespace tandem::server
