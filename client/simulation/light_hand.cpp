#include "client/simulation/light_hand.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::client {

using sync::Micros;

namespace {

constexpr Micros kEmptyPeriod = 200 * sync::kMillisecond;

}  // namespace

LightHand::LightHand(const assets::Scene& scene, const std::vector<ScriptStep>& script, Exchange& exchange)
    : script_(script), exchange_(exchange), frame_(sync::wireFrame(scene.bounds)) {
  for (const assets::Part& part : scene.parts) poses_.push_back(part.worldFromPart);
}

LightHand::Mine* LightHand::find(PartId part) {
  for (Mine& mine : mine_)
    if (mine.part == part) return &mine;
  return nullptr;
}

bool LightHand::push(HandIntent intent) {
  intent.lost = lost_;
  return exchange_.intents.push(intent);
}

double LightHand::nextDue() const {
  if (t_ < movesUntil_ || !links_.empty()) return t_;
  return next_ < script_.size() ? script_[next_].at : -1.0;
}

void LightHand::step(double t, Micros now) {
  NetworkEvent event;
  while (exchange_.events.pop(event)) handle(event);
  const double moved = t_ < 0.0 ? 0.0 : std::max(0.0, std::min(t, movesUntil_) - t_);
  if (held_ != kNoPart && moved > 0.0) {
    // A part that somebody has put to the edge of the scene's reach is moved no further.
    const glm::dvec3 goal = poses_[held_].position + velocity_ * moved;
    if (sync::contains(frame_, goal)) poses_[held_].position = goal;
  }
  // What the script says of the time before this client was started is over.
  while (t_ < 0.0 && next_ < script_.size() && script_[next_].at < t) ++next_;
  t_ = t;
  while (next_ < script_.size() && script_[next_].at <= t) play(script_[next_++]);
  // What settles here without a hand is given back, as after a grant that comes too late.
  for (Mine& mine : mine_)
    if (mine.part != held_ && mine.part != asked_ && mine.epoch != 0 && !mine.releasing) letGo(mine);
  sendLinkPackets(now);
  publish(now);
}

void LightHand::play(const ScriptStep& step) {
  switch (step.verb) {
    case ScriptStep::Verb::grasp:
      if (held_ != kNoPart || asked_ != kNoPart) return;
      if (find(step.part) != nullptr && !find(step.part)->releasing) {
        held_ = step.part;
      } else if (push({HandIntent::Kind::grab, step.part, 0, {}})) {
        asked_ = step.part;
      }
      return;
    case ScriptStep::Verb::release:
      if (asked_ != kNoPart) static_cast<void>(push({HandIntent::Kind::leave, asked_, 0, {}}));
      asked_ = kNoPart;
      if (Mine* mine = find(held_)) letGo(*mine);
      return;
    case ScriptStep::Verb::moveRelative:
      if (held_ == kNoPart || step.over <= 0.0) return;
      velocity_ = step.vector / step.over;
      movesUntil_ = t_ + step.over;
      return;
    default:
      return;
  }
}

/// Gives a part back to the server, or to its owner.
void LightHand::letGo(Mine& mine) {
  if (held_ == mine.part) {
    held_ = kNoPart;
    movesUntil_ = -1.0;
  }
  if (mine.epoch != 0) {
    mine.releasing = push({HandIntent::Kind::release, mine.part, mine.epoch, poses_[mine.part]});
  } else if (push({HandIntent::Kind::leave, mine.part, 0, {}})) {
    drop(mine.part);
  }
}

void LightHand::drop(PartId part) {
  if (held_ == part) {
    held_ = kNoPart;
    movesUntil_ = -1.0;
  }
  std::erase_if(mine_, [&](const Mine& mine) { return mine.part == part; });
  std::erase_if(links_, [&](const Link& link) { return link.terms.id.part == part; });
}

void LightHand::handle(const NetworkEvent& event) {
  switch (event.kind) {
    case NetworkEvent::Kind::state:
      if (find(event.state.part) == nullptr) poses_[event.state.part] = event.state.worldFromPart;
      return;
    case NetworkEvent::Kind::ownership:
      return onOwnership(event.record);
    case NetworkEvent::Kind::denied:
      if (asked_ == event.record.part) asked_ = kNoPart;
      if (const Mine* mine = find(event.record.part); mine != nullptr && mine->epoch == 0) {
        drop(event.record.part);
        poses_[event.record.part] = event.record.worldFromPart;
      }
      return;
    case NetworkEvent::Kind::link:
      return onLink(event);
    case NetworkEvent::Kind::unlink:
      std::erase_if(links_, [&](const Link& link) { return link.terms.id == event.link.id; });
      return;
    case NetworkEvent::Kind::simulators:
    case NetworkEvent::Kind::place:  // these people take nothing back
      return;
    case NetworkEvent::Kind::lost:
      return onLost();
  }
}

void LightHand::onLost() {
  ++lost_;
  asked_ = kNoPart;
  for (Mine& mine : mine_) mine.releasing = false;  // asked again once a server answers
}

void LightHand::onOwnership(const sync::PartRecord& record) {
  const SiteId self = exchange_.timeBase.latest().self;
  Mine* mine = find(record.part);
  if (record.owner == self && self != kNoSite) {
    if (mine != nullptr) {
      mine->releasing = mine->releasing && mine->epoch == record.epoch;
      mine->epoch = record.epoch;
      return;
    }
    if (mine_.size() >= haptics::kMaxOwnedParts) return;
    mine_.push_back({record.part, record.epoch, false});
    poses_[record.part] = record.worldFromPart;
    if (asked_ != record.part) return;
    held_ = record.part;
    asked_ = kNoPart;
    ++granted_;
    return;
  }
  if (mine != nullptr && record.owner != kNoSite) {
    if (mine->epoch == 0) return;  // the link to the new owner follows
    if (held_ == record.part && push({HandIntent::Kind::grab, record.part, 0, {}})) {
      mine->epoch = 0;
      mine->releasing = false;
      return;
    }
  }
  if (mine != nullptr) drop(record.part);
  poses_[record.part] = record.worldFromPart;
}

void LightHand::onLink(const NetworkEvent& event) {
  const PartId part = event.link.id.part;
  if (event.ownedByPeer && find(part) == nullptr) {
    if (asked_ != part || mine_.size() >= haptics::kMaxOwnedParts) {
      static_cast<void>(push({HandIntent::Kind::leave, part, 0, {}}));
      return;
    }
    mine_.push_back({part, 0, false});
    held_ = part;
    asked_ = kNoPart;
    ++granted_;
  }
  std::erase_if(links_, [&](const Link& link) { return link.terms.id == event.link.id; });
  links_.push_back({event.link});
}

/// A packet of each link now and then: that they pass is the protocol's, what is in them the hand's.
void LightHand::sendLinkPackets(Micros now) {
  haptics::AddressedPacket packet;
  while (exchange_.linksIn.pop(packet)) continue;
  for (Link& link : links_) {
    packet = {};
    packet.link = link.terms.id;
    packet.packet.epoch = link.terms.epoch;
    packet.packet.sequence = link.sent++;
    packet.packet.time = sync::toSeconds(now + exchange_.timeBase.latest().offset);
    packet.packet.on = true;
    static_cast<void>(exchange_.linksOut.push(packet));
  }
}

void LightHand::publish(Micros now) {
  // An empty hand is published seldom: the copies cost more than the rest of its step.
  if (mine_.empty() && output_.tick.ownedCount == 0 && now - output_.time < kEmptyPeriod) return;
  output_.time = now;
  output_.tick.ownedCount = 0;
  for (const Mine& mine : mine_) {
    const auto index = static_cast<std::size_t>(output_.tick.ownedCount++);
    haptics::OwnedPart& part = output_.tick.owned[index];
    part = {};
    part.part = mine.part;
    part.worldFromPart = poses_[mine.part];
    part.held = mine.part == held_;
    part.atRest = !part.held || t_ >= movesUntil_;
    if (!part.atRest) part.twist.linear = velocity_;
    output_.ownedEpoch[index] = mine.releasing ? 0 : mine.epoch;
  }
  output_.tick.hands[0].held = held_;
  output_.grabPending = asked_ != kNoPart;
  exchange_.output.write(output_);
}

}  // namespace tandem::client
