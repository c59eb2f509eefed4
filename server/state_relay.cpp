#include "server/state_relay.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

constexpr sync::Micros kMaxAhead = 5 * sync::kSecond;  // of session time, by a site's estimate
constexpr sync::Micros kFloodNoticePeriod = 10 * sync::kSecond;
constexpr sync::Micros kMaxBehind = 60 * sync::kSecond;

}  // namespace

StateRelay::StateRelay(const sync::WireFrame& frame, SessionContext& context, Peers& peers,
                       PartService& parts, Publisher& publisher, FanOut& fanOut)
    : frame_(frame), context_(context), peers_(peers), parts_(parts), publisher_(publisher), fanOut_(fanOut) {
  encoded_.reserve(sync::kMaxStateBytes);
  std::get<sync::StateUpdate>(incoming_).parts.reserve(256);
}

/// Two token buckets, because a site with many links must keep its parts and pings: kMaxDatagramRate or
/// kMaxLinkRate messages a second, kDatagramBurst at once.
bool StateRelay::withinRate(StateLeg& leg, bool ofLink) const {
  ASSERT(context_.now() >= leg.allowanceAt);
  const double elapsed = sync::toSeconds(context_.now() - leg.allowanceAt);
  leg.allowance = std::min(kDatagramBurst, leg.allowance + elapsed * kMaxDatagramRate);
  leg.linkAllowance = std::min(kDatagramBurst, leg.linkAllowance + elapsed * kMaxLinkRate);
  leg.allowanceAt = context_.now();
  double& allowance = ofLink ? leg.linkAllowance : leg.allowance;
  if (allowance < 1.0) return false;
  allowance -= 1.0;
  ASSERT(allowance >= 0.0 && allowance <= kDatagramBurst);
  return true;
}

/// Not more often than every kFloodNoticePeriod.
void StateRelay::noteFlood(Peer& peer) {
  StateLeg& leg = peer.states;
  if (context_.now() < leg.nextFloodNotice || peer.site == kNoSite) return;
  leg.nextFloodNotice = context_.now() + kFloodNoticePeriod;
  context_.log.note(parts_.siteName(peer.site) + " sends more states than a site may: some are dropped",
                    peer.site);
}

void StateRelay::onDatagram(Peer& peer, std::span<const std::byte> datagram) {
  while (onMessage(peer, sync::popMessage(datagram)) && !datagram.empty()) continue;
}

bool StateRelay::onMessage(Peer& peer, std::span<const std::byte> bytes) {
  context_.counts.received.countState(bytes);
  if (!withinRate(peer.states, sync::isLinkUpdate(bytes))) {
    ++context_.counts.droppedFlood;
    noteFlood(peer);
    return false;
  }
  sync::StateMessage& message = sync::isStateUpdate(bytes) ? incoming_ : incomingShort_;
  using Outcome = sync::StateReceiver::Outcome;
  const Outcome outcome = peer.states.receiver.decode(bytes, frame_, message);
  if (outcome == Outcome::malformed) {
    ++context_.counts.droppedMalformed;
    return true;
  }
  peer.lastReceived = context_.now();
  if (outcome != Outcome::decoded) {
    ++context_.counts.droppedBaselines;
    return true;
  }
  if (const auto* ping = std::get_if<sync::Ping>(&message)) {
    onPing(peer, *ping);
  } else if (std::holds_alternative<sync::StateUpdate>(message)) {
    onUpdate(peer, message);
  } else if (std::holds_alternative<sync::LinkUpdate>(message)) {
    onLink(peer, message);
  } else if (const auto* ack = std::get_if<sync::StateAck>(&message)) {
    fanOut_.acknowledged(peer, *ack);
  } else {
    ++context_.counts.droppedMalformed;  // only the server sends this
  }
  return true;
}

/// A LinkUpdate passes between the owner of a part and one of its co-holders, in either direction.
void StateRelay::onLink(Peer& peer, sync::StateMessage& message) {
  auto& link = std::get<sync::LinkUpdate>(message);
  if (peer.stage != Stage::ready) {
    ++context_.counts.droppedEarly;
    return;
  }
  Peer* other = link.part < parts_.count() ? peers_.bySite(link.peer) : nullptr;
  if (other == nullptr || other->stage != Stage::ready ||
      !parts_.table().areLinked(link.part, peer.site, link.peer)) {
    ++context_.counts.droppedLinks;
    return;
  }
  ASSERT(other->site != peer.site);
  link.peer = peer.site;
  ++context_.counts.relayedLinks;
  sync::encodeState(message, frame_, encoded_);
  fanOut_.send(*other, encoded_);
}

void StateRelay::onPing(Peer& peer, const sync::Ping& ping) {
  if (peer.stage == Stage::hello) {
    ++context_.counts.droppedEarly;
    return;
  }
  // Whatever is answered renews, for the pong renews the site's own lease (S3). A site pings once it is
  // ready; its Ready goes by TLS, where it may wait for what was lost before it, so that the ping overtakes
  // it.
  parts_.renew(peer.site);
  sync::encodeState(sync::Pong{ping.sequence, ping.siteTime, context_.now(), peer.states.updatesIn}, frame_,
                    encoded_);
  fanOut_.send(peer, encoded_);
}

/// Acknowledges the updates of the site, which may encode the next ones against them.
void StateRelay::acknowledge(Peer& peer) {
  const std::optional<sync::StateAck> ack = peer.states.receiver.drainAck(context_.now());
  if (!ack) return;
  sync::encodeState(*ack, frame_, encoded_);
  fanOut_.sendSoon(peer, encoded_);
}

bool StateRelay::plausible(const sync::StateUpdate& update) const {
  const sync::Micros now = context_.now();
  if (update.time > now + kMaxAhead || update.time < now - kMaxBehind) return false;
  if (update.presence.touched != kNoPart && update.presence.touched >= parts_.count()) return false;
  return std::all_of(update.parts.begin(), update.parts.end(),
                     [&](const sync::PartState& state) { return state.part < parts_.count(); });
}

void StateRelay::onUpdate(Peer& peer, sync::StateMessage& message) {
  SessionCounters& counts = context_.counts;
  if (peer.stage != Stage::ready) {
    ++counts.droppedEarly;
    return;
  }
  acknowledge(peer);
  auto& update = std::get<sync::StateUpdate>(message);
  if (!plausible(update)) {
    ++counts.droppedMalformed;
    return;
  }
  StateLeg& leg = peer.states;
  ++leg.updatesIn;
  const bool newest =
      leg.updatesIn == 1 || static_cast<std::int32_t>(update.sequence - leg.lastSequenceIn) > 0;
  if (newest) leg.lastSequenceIn = update.sequence;
  update.newPresence = newest && update.newPresence;
  if (update.newPresence) leg.presence = update.presence;

  const auto refused =
      std::remove_if(update.parts.begin(), update.parts.end(),
                     [&](const sync::PartState& state) { return !parts_.accept(peer.site, state); });
  counts.droppedStates += static_cast<std::uint64_t>(update.parts.end() - refused);
  update.parts.erase(refused, update.parts.end());
  if (update.parts.empty() && !update.newPresence) return;

  update.site = update.presence.site = peer.site;
  if (update.presenceKnown) publisher_.record(message);
  ++counts.relayedUpdates;
  counts.relayedParts += update.parts.size();
  fanOut_.relay(peer, update, newest);
}

}  // namespace tandem::server
