#include "server/fan_out.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

constexpr std::size_t kFewAgain = 12;  // sites at which a crowd ends
/// So many parts fit into a datagram however they are encoded; only with more does their order matter.
constexpr std::size_t kAlwaysFit = 25;

/// Sorts the parts by what the viewer needs first: the part that it touches, then those before its camera,
/// then those behind it. Where not all fit into one datagram, the last ones wait.
void sortFor(const sync::Presence& viewer, std::vector<sync::PartState>& parts) {
  const Pose cameraFromWorld = inverse(viewer.worldFromCamera);
  const auto rank = [&](const sync::PartState& state) {
    if (state.part == viewer.touched) return -2.0;
    const glm::dvec3 place = transformPoint(cameraFromWorld, state.worldFromPart.position);
    // A camera looks along -z: -1 is the middle of its view.
    return place.z / std::max(glm::length(place), 1e-9);
  };
  std::sort(parts.begin(), parts.end(), [&](const sync::PartState& a, const sync::PartState& b) {
    const double first = rank(a), second = rank(b);
    return first != second ? first < second : a.part < b.part;
  });
}

bool same(const Pose& a, const Pose& b) { return a.position == b.position && a.orientation == b.orientation; }

/// Whether every part of `before` is in `now`, in the same epoch.
bool covers(const sync::StateUpdate& now, const sync::StateUpdate& before) {
  return std::all_of(before.parts.begin(), before.parts.end(), [&](const sync::PartState& old) {
    return std::any_of(now.parts.begin(), now.parts.end(), [&](const sync::PartState& state) {
      return state.part == old.part && state.epoch == old.epoch;
    });
  });
}

/// Whether a receiver of `shown` draws the same from `now`: everything is at rest where it was.
bool unchanged(const sync::StateUpdate& now, const sync::StateUpdate& shown) {
  const sync::Presence &a = now.presence, &b = shown.presence;
  if (a.touched != b.touched || !same(a.worldFromTool, b.worldFromTool) ||
      !same(a.worldFromCamera, b.worldFromCamera) || a.worldFromSecondTool.has_value() ||
      b.worldFromSecondTool.has_value() || now.parts.size() != shown.parts.size())
    return false;
  for (std::size_t i = 0; i < now.parts.size(); ++i) {
    const sync::PartState &state = now.parts[i], &old = shown.parts[i];
    if (state.part != old.part || state.epoch != old.epoch || !isStill(state.twist) || !isStill(old.twist) ||
        !same(state.worldFromPart, old.worldFromPart))
      return false;
  }
  return true;
}

bool moves(const sync::StateUpdate& update, PartId part) {
  return std::any_of(update.parts.begin(), update.parts.end(),
                     [&](const sync::PartState& state) { return state.part == part; });
}

}  // namespace

FanOut::FanOut(const assets::Scene& scene, const sync::WireFrame& frame, SessionContext& context,
               sync::Transport& transport, Peers& peers, const PartService& parts)
    : frame_(frame),
      context_(context),
      transport_(transport),
      peers_(peers),
      parts_(parts),
      interest_(scene) {
  encoded_.reserve(sync::kMaxStateBytes);
}

// ---- datagrams ----

void FanOut::WaitingLine::push(Waiting waiting) {
  if (first > 64 && first * 2 > all.size()) {
    all.erase(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(first));
    first = 0;
  }
  ASSERT(all.size() == first || all.back().by <= waiting.by);
  all.push_back(waiting);
}

void FanOut::queue(Peer& peer, std::span<const std::byte> message, sync::Micros by) {
  ASSERT(!message.empty() && message.size() <= sync::kMaxStateBytes && by >= context_.now());
  context_.counts.sent.countState(message);
  StateLeg& leg = peer.states;
  if (!leg.unsent.add(message)) {
    sendNow(peer);
    leg.unsent.add(message);
  }
  if (by >= leg.unsentBy) return;
  leg.unsentBy = by;
  if (by == context_.now())
    leaving_.push_back(peer.connection);
  else
    (by == context_.now() + kSiteHold ? waitingSites_ : waitingObservers_).push({peer.connection, by});
}

void FanOut::sendSoon(Peer& peer, std::span<const std::byte> message) {
  queue(peer, message, context_.now() + (crowd_ ? kSiteHold : 0));
}

void FanOut::sendNow(Peer& peer) {
  StateLeg& leg = peer.states;
  if (!leg.unsent.bytes().empty()) transport_.sendState(peer.connection, leg.unsent.bytes());
  leg.unsent.clear();
  leg.unsentBy = kNotWaiting;
}

void FanOut::sendDue(WaitingLine& line) {
  for (; line.front() != nullptr && line.front()->by <= context_.now(); line.pop())
    if (Peer* peer = peers_.find(line.front()->connection);
        peer != nullptr && peer->states.unsentBy <= context_.now())
      sendNow(*peer);
}

void FanOut::flush() {
  const sync::Micros now = context_.now();
  if (now >= nextInterest_) {
    listReady();
    if (crowd_) compareAll();
    nextInterest_ = now + kInterestPeriod;
  }
  if (crowd_ && now >= nextPending_) {
    nextPending_ = now + kPendingPeriod;
    if (listed_ != peers_.changes()) listReady();
    for (auto* list : {&sites_, &observers_})
      for (Peer* peer : *list) deliverPending(*peer);
  }
  for (const sync::ConnectionId connection : leaving_)
    if (Peer* peer = peers_.find(connection); peer != nullptr && peer->states.unsentBy <= now) sendNow(*peer);
  leaving_.clear();
  sendDue(waitingSites_);
  sendDue(waitingObservers_);
  transport_.flush();
}

sync::Micros FanOut::nextDeadline() const {
  sync::Micros next = crowd_ ? std::min(nextInterest_, nextPending_) : kNotWaiting;
  for (const WaitingLine* line : {&waitingSites_, &waitingObservers_})
    if (line->front() != nullptr) next = std::min(next, line->front()->by);
  return next;
}

// ---- who is there, and near whom ----

void FanOut::listReady() {
  sites_.clear();
  observers_.clear();
  listed_ = peers_.changes();
  for (auto& [connection, peer] : peers_) {
    if (peer.stage != Stage::ready) continue;
    auto& list = peer.role == sync::Role::observer ? observers_ : sites_;
    peer.states.place = list.size();
    list.push_back(&peer);
  }
  const std::size_t all = sites_.size() + observers_.size();
  // Until they are compared, all are near.
  if (pairs_.size() != sites_.size() * sites_.size())
    pairs_.assign(sites_.size() * sites_.size(), Pair{1, false});
  nextInterest_ = context_.now();
  if (const bool crowd = all > (crowd_ ? kFewAgain : kFewSites); crowd != crowd_) changeTo(crowd);
}

/// Baselines of the one kind of encoding serve the other one nothing.
void FanOut::changeTo(bool crowd) {
  for (auto* list : {&sites_, &observers_})
    for (Peer* peer : *list)
      if (peer->states.shown.pending) deliver(*peer, peer->states.shown.newest, true);
  for (auto& [connection, peer] : peers_) {
    peer.states.sender.reset();
    peer.states.shared = {};
    peer.states.shown = {};
  }
  crowd_ = crowd;
}

void FanOut::compareAll() {
  for (const Peer* a : sites_)
    for (const Peer* b : sites_) {
      if (a->states.place >= b->states.place) continue;
      Pair &one = pair(*a, *b), &other = pair(*b, *a);
      const bool touches = touching(*a, *b) || touching(*b, *a);
      const bool near = touches || interest_.near(a->states.reach, b->states.reach);
      if (near)
        one.near = kNearTicks;
      else if (one.near > 0)
        --one.near;
      one.touches = touches;
      other = one;
    }
}

/// Whether one of the parts that `b` moves is touched or co-held by `a`.
bool FanOut::touching(const Peer& a, const Peer& b) const {
  const PartId touched = a.states.presence.touched;
  const sync::StateUpdate& update = b.states.shown.newest;
  if (touched != kNoPart && (moves(update, touched) || b.states.presence.touched == touched)) return true;
  return std::any_of(update.parts.begin(), update.parts.end(), [&](const sync::PartState& state) {
    return parts_.table().areLinked(state.part, a.site, b.site);
  });
}

// ---- updates ----

void FanOut::acknowledged(Peer& peer, const sync::StateAck& ack) {
  peer.states.sender.acknowledged(ack);
  peer.states.shared.acknowledged(ack);
}

void FanOut::forget(SiteId origin) {
  ASSERT(origin != kNoSite);
  shared_.forget(origin);
  for (auto& [connection, peer] : peers_) peer.states.sender.forget(origin);
}

void FanOut::relayToAll(const Peer& from, sync::StateUpdate& update) {
  for (auto& [connection, other] : peers_) {
    if (other.stage != Stage::ready || other.site == from.site) continue;
    update.sequence = ++other.states.sequenceOut;
    if (update.parts.size() > kAlwaysFit) sortFor(other.states.presence, update.parts);
    other.states.sender.encode(update, frame_, encoded_);
    send(other, encoded_);
  }
}

sync::Micros FanOut::displayPeriod(const Peer& from, const sync::StateUpdate& update) const {
  if (from.role == sync::Role::observer) return kObserverPeriod;
  return unchanged(update, from.states.shown.toAll) ? kStillPeriod : kDisplayPeriod;
}

void FanOut::relay(Peer& from, sync::StateUpdate& update, bool newest) {
  ASSERT(from.stage == Stage::ready && update.site == from.site);
  Shown& shown = from.states.shown;
  if (update.presenceKnown && newest) interest_.observe(update, from.states.reach);
  if (!crowd_ || update.parts.size() > sync::kMaxSharedParts) return relayToAll(from, update);
  if (listed_ != peers_.changes()) listReady();
  if (!newest) return deliver(from, update, false);
  if (shown.pending && !covers(update, shown.newest)) deliver(from, shown.newest, true);
  const bool changed = !unchanged(update, shown.toAll);
  const bool due = context_.now() - shown.at >= displayPeriod(from, update);
  update.newPresence = update.newPresence || (due && shown.presenceOwed && update.presenceKnown);
  shown.presenceOwed = !due && (shown.presenceOwed || update.newPresence);
  shown.newest = update;
  shown.pending = !due && changed;
  deliver(from, update, due);
}

/// The newest state before a pause.
void FanOut::deliverPending(Peer& from) {
  Shown& shown = from.states.shown;
  if (!shown.pending || context_.now() - shown.at < 2 * displayPeriod(from, shown.newest)) return;
  shown.newest.newPresence = shown.newest.newPresence || (shown.presenceOwed && shown.newest.presenceKnown);
  shown.presenceOwed = false;
  deliver(from, shown.newest, true);
}

void FanOut::deliver(Peer& from, const sync::StateUpdate& update, bool toAll) {
  const bool ofObserver = from.role == sync::Role::observer;
  if (ofObserver && !toAll) return;
  const sync::Micros now = context_.now();
  shared_.begin(update, frame_, toAll);
  for (Peer* other : sites_) {
    if (other->site == from.site) continue;
    const Pair with = ofObserver ? Pair{} : pair(*other, from);
    if (!toAll && with.near == 0) continue;
    queue(*other, shared_.encodeFor(other->states.shared, ++other->states.sequenceOut),
          with.touches ? now : now + kSiteHold);
  }
  if (!toAll) return;
  Shown& shown = from.states.shown;
  shown.at = now;
  shown.pending = false;
  shown.toAll = update;
  if (ofObserver) return;
  for (Peer* other : observers_)
    queue(*other, shared_.encodeFor(other->states.shared, ++other->states.sequenceOut), now + kObserverHold);
}

}  // namespace tandem::server
