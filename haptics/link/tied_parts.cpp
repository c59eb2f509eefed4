#include "haptics/link/tied_parts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr double kForceLeft = 0.01;  // N, below which a link that has ended may be dropped

Pose centreOf(const RigidBody& body) {
  return {transformPoint(body.worldFromBody, body.centreOfMass), body.worldFromBody.orientation};
}

}  // namespace

std::optional<TiedParts::End>* TiedParts::slotOf(PartId part, SiteId peer) {
  for (std::optional<End>& end : ends_) {
    if (end && end->part == part && end->peer == peer) return &end;
  }
  return nullptr;
}

TiedParts::Shared* TiedParts::find(PartId part) {
  for (int i = 0; i < sharedCount_; ++i) {
    if (shared_[static_cast<std::size_t>(i)].part == part) return &shared_[static_cast<std::size_t>(i)];
  }
  return nullptr;
}

const TiedParts::Shared* TiedParts::find(PartId part) const {
  return const_cast<TiedParts*>(this)->find(part);
}

template <typename F>
void TiedParts::forEachEnd(PartId part, const F& f) {
  for (std::optional<End>& end : ends_) {
    if (end && end->part == part) f(*end);
  }
}

bool TiedParts::tie(const PartTie& tie, const RigidBody& body) {
  ASSERT(body.mass > 0.0);
  std::optional<End>* slot = slotOf(tie.part, tie.peer);
  if (slot != nullptr && tie.carriesOn && (*slot)->link.on()) {
    (*slot)->link.carryOn(tie.epoch);
    (*slot)->leashed = tie.leashed;
    return true;
  }
  if (slot == nullptr) {
    slot = std::find_if(ends_.begin(), ends_.end(), [](const auto& end) { return !end.has_value(); });
    if (slot == ends_.end()) return false;
    Shared* shared = find(tie.part);
    if (shared == nullptr) {
      if (sharedCount_ == kMaxOwnedParts) return false;
      shared_[static_cast<std::size_t>(sharedCount_++)] = {
          tie.part, 1, {body.mass, body.centreOfMass, body.inertia}, {}, 1.0};
    }
    slot->emplace(tie);
  }
  End& end = **slot;
  end.leashed = tie.leashed;
  // The outage spring of the part passes on to the tie with the new owner.
  if (tie.leashed)
    forEachEnd(tie.part, [&](End& other) {
      if (&other != &end && other.leash.share() > 0.0) end.leash = std::exchange(other.leash, {});
    });
  end.link.setFarthest(tie.link.farthest);
  end.link.setImpedance(tie.link.impedance, tie.link.softImpedance);
  end.link.begin(tie.epoch, tie.delay);
  return true;
}

void TiedParts::untie(PartId part, SiteId peer) {
  if (std::optional<End>* slot = slotOf(part, peer)) (*slot)->link.setOn(false);
}

void TiedParts::setSimulators(PartId part, int simulators) {
  if (Shared* shared = find(part)) shared->simulators = std::max(1, simulators);
}

void TiedParts::drop(Shared& shared) {
  ASSERT(sharedCount_ > 0 && sharedCount_ <= kMaxOwnedParts);
  shared = shared_[static_cast<std::size_t>(--sharedCount_)];
}

void TiedParts::forget(PartId part) {
  Shared* shared = find(part);
  if (shared == nullptr) return;
  for (std::optional<End>& end : ends_) {
    if (end && end->part == part) end.reset();
  }
  drop(*shared);
}

bool TiedParts::receive(PartId part, SiteId peer, const LinkPacket& packet) {
  std::optional<End>* slot = slotOf(part, peer);
  return slot != nullptr && (*slot)->link.receive(packet);
}

std::size_t TiedParts::takePackets(std::span<TiedPacket> packets) {
  std::size_t count = 0;
  if (sharedCount_ == 0) return count;
  for (std::optional<End>& end : ends_) {
    if (count == packets.size()) break;
    if (!end || end->sinceSent < end->parameters.packetPeriod - 0.5 * end->parameters.period) continue;
    packets[count++] = {end->part, end->peer, end->link.packet(now_)};
    end->sinceSent = 0.0;
  }
  ASSERT(count <= packets.size());

  return count;
}

/// A site that is too far away to be tied simulates the whole part; a hub shares the part with the sites that
/// are not.
assets::MassProperties TiedParts::shareOf(Shared& shared) {
  int live = 0, apart = 0;
  double lines = 0.0, lever = 0.0;
  forEachEnd(shared.part, [&](const End& end) {
    if (!end.link.on()) return;
    if (end.link.regime() == LinkRegime::apart) ++apart;
    ++live;
    lines += 0.5 * end.link.lineMass();
    lever = end.parameters.lever;
  });
  const int simulators = live == apart ? 1 : std::max(1, shared.simulators - apart);
  shared.share = 1.0 / simulators;
  return replicaMass(shared.whole, simulators, lines, lever);
}

void TiedParts::setMass(Shared& shared, RigidBody& body, double dt) {
  const assets::MassProperties target = shareOf(shared);
  if (body.mass == target.mass && body.inertia == target.inertia) return;
  shared.ramp.advance(body, target, dt);
  if (std::abs(body.mass - target.mass) > 1e-9 * target.mass) return;
  body.mass = target.mass;  // equal to the bit: a part that is alone again is what it was
  body.inertia = target.inertia;
}

LinkPull TiedParts::pull(PartId part, RigidBody& body, bool held, double now, double dt) {
  now_ = now;
  ASSERT(find(part) != nullptr);
  Shared& shared = *find(part);
  setMass(shared, body, dt);
  const Pose centre = centreOf(body);
  const Twist twist{velocityAt(body.worldFromBody, body.twist, centre.position), body.twist.angular};
  LinkPull sum;
  forEachEnd(part, [&](End& end) {
    if (end.leashed) end.link.setFarthest(held ? kFarthestHeld : kFarthestTouched);
    const LinkPull pull = end.link.pull(now, centre, twist);
    if (end.leashed || end.leash.share() > 0.0) {
      Leash::Lead lead = Leash::leadOf(end.link, now, held);
      lead.wanted = lead.wanted && end.leashed;
      end.leash.advance(centre, twist, lead, end.parameters.lever, dt);
    }
    sum.held = sum.held + pull.held;
    sum.damping += pull.damping;
    sum.rotDamping += pull.rotDamping;
    end.sinceSent += dt;
  });
  return sum;
}

const Leash* TiedParts::leash(PartId part) const {
  for (const std::optional<End>& end : ends_)
    if (end && end->part == part && end->leash.share() > 0.0) return &end->leash;
  return nullptr;
}

void TiedParts::settle(PartId part, const RigidBody& body, const glm::dvec3& velocity, const glm::dvec3& spin,
                       const Wrench& lead) {
  const Pose centre = centreOf(body);
  bool tied = false;
  for (std::optional<End>& end : ends_) {
    if (!end || end->part != part) continue;
    end->acting = end->link.settle(centre, {velocity, spin});
    const double torque = glm::length(end->acting.torque) / end->parameters.lever;
    const bool left =
        end->leash.share() > 0.0 || std::max(glm::length(end->acting.force), torque) > kForceLeft;
    end->lead = end->leash.share() > 0.0 ? lead : Wrench{};
    if (!end->link.on() && !left)
      end.reset();
    else
      tied = true;
  }
  ASSERT(find(part) != nullptr);
  Shared& shared = *find(part);
  if (!tied && body.mass == shared.whole.mass && body.inertia == shared.whole.inertia) drop(shared);
}

TieReport TiedParts::report(PartId part) const {
  TieReport report;
  const Shared* shared = sharedCount_ > 0 ? find(part) : nullptr;
  if (shared == nullptr) return report;
  report.share = shared->share;
  for (const std::optional<End>& end : ends_) {
    if (!end || end->part != part) continue;
    const CoordinationLink& link = end->link;
    report.fade = report.links == 0 ? link.fade() : std::min(report.fade, link.fade());
    ++report.links;
    report.regime = std::max(report.regime, link.regime());
    report.heard = report.heard && link.fresh();
    report.delay = std::max(report.delay, link.delay());
    report.pull.force += end->acting.force;
    report.pull.torque += end->acting.torque;
    report.lead.force += end->lead.force;
    report.lead.torque += end->lead.torque;
    report.work += link.account().work;
    report.lent += link.account().lent;
  }
  return report;
}

}  // namespace tandem::haptics
