// State datagrams: checked, filtered by ownership, relayed. Nothing here allocates once its buffers have
// grown.

#include <algorithm>

#include "server/session_state.h"

namespace tandem::server {
namespace {

constexpr sync::Micros kMaxAhead = 5 * sync::kSecond;  // of session time, by a site's estimate
constexpr sync::Micros kMaxBehind = 60 * sync::kSecond;
/// So many parts fit into a datagram however they are told: with longer ones their order matters.
constexpr std::size_t kAlwaysFit = 25;

}  // namespace

bool Session::State::withinRate(Peer& peer) {
  const double elapsed = sync::toSeconds(now - peer.allowanceAt);
  peer.allowance = std::min(kDatagramBurst, peer.allowance + elapsed * kMaxDatagramRate);
  peer.allowanceAt = now;
  if (peer.allowance < 1.0) return false;
  peer.allowance -= 1.0;
  return true;
}

/// What stateBytes holds, at the end of the step.
void Session::State::sendState(Peer& peer) {
  counts.sent.countState(stateBytes);
  peer.unsent.add(stateBytes, [&](auto datagram) { transport.sendState(peer.connection, datagram); });
}

void Session::State::flushStates(Peer& peer) {
  peer.unsent.flush([&](auto datagram) { transport.sendState(peer.connection, datagram); });
}

/// False beyond what the site may say.
bool Session::State::onState(Peer& peer, std::span<const std::byte> bytes) {
  counts.received.countState(bytes);
  if (!withinRate(peer)) {
    ++counts.droppedFlood;
    return false;
  }
  // An update is decoded into storage of its own, so that nothing else frees its vector.
  sync::StateMessage& message = sync::isStateUpdate(bytes) ? incoming : incomingShort;
  using Outcome = sync::StateReceiver::Outcome;
  const Outcome outcome = peer.statesIn.decode(bytes, frame, message);
  if (outcome == Outcome::malformed) {
    ++counts.droppedMalformed;
    return true;
  }
  peer.lastHeard = now;
  if (outcome != Outcome::taken) {
    ++counts.droppedBaselines;
    return true;
  }
  if (const auto* ping = std::get_if<sync::Ping>(&message)) {
    onPing(peer, *ping);
  } else if (std::holds_alternative<sync::StateUpdate>(message)) {
    onUpdate(peer, message);
  } else if (std::holds_alternative<sync::LinkUpdate>(message)) {
    onLink(peer, message);
  } else if (const auto* ack = std::get_if<sync::StateAck>(&message)) {
    peer.statesOut.acknowledged(*ack);
  } else {
    ++counts.droppedMalformed;  // only the server says this
  }
  return true;
}

/// From one who simulates a part to another: guest to owner, or owner to guest.
void Session::State::onLink(Peer& peer, sync::StateMessage& message) {
  auto& link = std::get<sync::LinkUpdate>(message);
  if (peer.stage != Stage::ready) {
    ++counts.droppedEarly;
    return;
  }
  Peer* other = link.part < scene.parts.size() ? peerOf(link.peer) : nullptr;
  if (other == nullptr || other->stage != Stage::ready || !table.tied(link.part, peer.site, link.peer)) {
    ++counts.droppedLinks;
    return;
  }
  link.peer = peer.site;
  ++counts.relayedLinks;
  sync::encodeState(message, frame, stateBytes);
  sendState(*other);
}

void Session::State::onPing(Peer& peer, const sync::Ping& ping) {
  if (peer.stage == Stage::hello) {
    ++counts.droppedEarly;
    return;
  }
  // A site that is still loading cannot own anything that it feels: only ready sites renew (S3).
  if (peer.stage == Stage::ready) table.renew(peer.site, now);
  sync::encodeState(sync::Pong{ping.sequence, ping.siteTime, now, peer.updatesIn}, frame, stateBytes);
  sendState(peer);
}

/// The site may tell what follows against what has come.
void Session::State::acknowledge(Peer& peer) {
  const std::optional<sync::StateAck> ack = peer.statesIn.takeAck(now);
  if (!ack) return;
  sync::encodeState(*ack, frame, stateBytes);
  sendState(peer);
}

/// Of a site that is not coming back.
void Session::State::forgetStates(SiteId origin) {
  for (auto& [connection, peer] : peers) peer.statesOut.forget(origin);
}

/// What this site touches first, then what lies before its eyes, then what lies behind them: where not all fit into one
/// datagram, the last ones wait.
void Session::State::orderFor(const Peer& peer, std::vector<sync::PartState>& parts) const {
  const Pose cameraFromWorld = inverse(peer.presence.worldFromCamera);
  const auto rank = [&](const sync::PartState& state) {
    if (state.part == peer.presence.touched) return -2.0;
    const glm::dvec3 place = transformPoint(cameraFromWorld, state.worldFromPart.position);
    return place.z /
           std::max(glm::length(place), 1e-9);  // a camera looks along -z: -1 is the middle of its view
  };
  std::sort(parts.begin(), parts.end(), [&](const sync::PartState& a, const sync::PartState& b) {
    const double first = rank(a), second = rank(b);
    return first != second ? first < second : a.part < b.part;
  });
}

bool Session::State::plausible(const sync::StateUpdate& update) const {
  if (update.time > now + kMaxAhead || update.time < now - kMaxBehind) return false;
  if (update.presence.touched != kNoPart && update.presence.touched >= scene.parts.size()) return false;
  return std::all_of(update.parts.begin(), update.parts.end(),
                     [&](const sync::PartState& state) { return state.part < scene.parts.size(); });
}

void Session::State::onUpdate(Peer& peer, sync::StateMessage& message) {
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
  ++peer.updatesIn;
  const bool newest =
      peer.updatesIn == 1 || static_cast<std::int32_t>(update.sequence - peer.lastSequenceIn) > 0;
  if (newest) peer.lastSequenceIn = update.sequence;
  update.newPresence = newest && update.newPresence;
  if (update.newPresence) peer.presence = update.presence;

  const auto refused =
      std::remove_if(update.parts.begin(), update.parts.end(),
                     [&](const sync::PartState& state) { return !table.accept(peer.site, state); });
  counts.droppedStates += static_cast<std::uint64_t>(update.parts.end() - refused);
  update.parts.erase(refused, update.parts.end());
  for (const sync::PartState& state : update.parts) {
    if (moved[state.part]) continue;
    moved[state.part] = true;
    movedParts.push_back(state.part);
  }
  // An old presence, or none, and nothing else of use.
  if (update.parts.empty() && !update.newPresence) return;

  update.site = update.presence.site = peer.site;
  if (recording != nullptr && update.presenceKnown) recording->write(now, message);
  ++counts.relayedUpdates;
  counts.relayedParts += update.parts.size();
  for (auto& [connection, other] : peers) {
    if (other.stage != Stage::ready || other.site == peer.site) continue;
    update.sequence = ++other.sequenceOut;
    if (update.parts.size() > kAlwaysFit) orderFor(other, update.parts);
    other.statesOut.encode(update, frame, stateBytes);
    sendState(other);
  }
}

}  // namespace tandem::server
