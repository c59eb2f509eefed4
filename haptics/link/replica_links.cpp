#include "haptics/link/replica_links.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/link/link_distance.h"

namespace tandem::haptics {
namespace {

constexpr double kForceLeft = 0.01;  // N, below which a link that has ended may be dropped

Pose centreOf(const RigidBody& body) {
  return {transformPoint(body.worldFromBody, body.centreOfMass), body.worldFromBody.orientation};
}

}  // namespace

void ReplicaLinks::order(const LinkTerms& terms) {
  dropOrders([&](const LinkTerms& order) { return order.id == terms.id; });
  if (!orders_.full()) orders_.push_back(terms);
}

std::optional<ReplicaLinks::LinkEnd>* ReplicaLinks::slotOf(LinkId link) {
  for (std::optional<LinkEnd>& end : ends_) {
    if (end && end->terms.id == link) return &end;
  }
  return nullptr;
}

ReplicaLinks::LinkedPart* ReplicaLinks::find(PartId part) {
  for (LinkedPart& linked : parts_) {
    if (linked.part == part) return &linked;
  }
  return nullptr;
}

const ReplicaLinks::LinkedPart* ReplicaLinks::find(PartId part) const {
  return const_cast<ReplicaLinks*>(this)->find(part);
}

template <typename F>
void ReplicaLinks::forEachEnd(PartId part, const F& f) {
  for (std::optional<LinkEnd>& end : ends_) {
    if (end && end->terms.id.part == part) f(*end);
  }
}

bool ReplicaLinks::begin(const LinkTerms& terms, const RigidBody& body) {
  ASSERT(body.mass > 0.0);
  std::optional<LinkEnd>* slot = slotOf(terms.id);
  if (slot != nullptr && terms.carriesOn && (*slot)->link.on()) {
    (*slot)->link.carryOn(terms.epoch);
    (*slot)->terms.outageSpring = terms.outageSpring;
    return true;
  }
  if (slot == nullptr) {
    slot = std::find_if(ends_.begin(), ends_.end(), [](const auto& end) { return !end.has_value(); });
    if (slot == ends_.end()) return false;
    if (find(terms.id.part) == nullptr) {
      if (parts_.full()) return false;
      parts_.push_back({terms.id.part, 1, {body.mass, body.centreOfMass, body.inertia}, {}, 1.0});
    }
    slot->emplace(terms);
  }
  LinkEnd& end = **slot;
  end.terms.outageSpring = terms.outageSpring;
  // The outage spring of the part passes on to the link with the new owner.
  if (terms.outageSpring)
    forEachEnd(terms.id.part, [&](LinkEnd& other) {
      if (&other != &end && other.outageSpring.share() > 0.0)
        end.outageSpring = std::exchange(other.outageSpring, {});
    });
  end.link.setLongestDelay(terms.parameters.longestDelay);
  end.link.setImpedance(terms.parameters.impedance, terms.parameters.softImpedance);
  end.link.begin(terms.epoch, terms.delay);
  return true;
}

void ReplicaLinks::end(LinkId link) {
  dropOrders([&](const LinkTerms& order) { return order.id == link; });
  if (std::optional<LinkEnd>* slot = slotOf(link)) (*slot)->link.setOn(false);
}

void ReplicaLinks::setSimulators(PartId part, int simulators) {
  if (LinkedPart* linked = find(part)) linked->simulators = std::max(1, simulators);
}

void ReplicaLinks::drop(LinkedPart& linked) {
  linked = parts_.back();
  parts_.pop_back();
}

void ReplicaLinks::forget(PartId part) {
  LinkedPart* linked = find(part);
  if (linked == nullptr) return;
  for (std::optional<LinkEnd>& end : ends_) {
    if (end && end->terms.id.part == part) end.reset();
  }
  drop(*linked);
}

bool ReplicaLinks::receive(const AddressedPacket& packet) {
  std::optional<LinkEnd>* slot = slotOf(packet.link);
  return slot != nullptr && (*slot)->link.receive(packet.packet);
}

std::size_t ReplicaLinks::drainPackets(std::span<AddressedPacket> packets) {
  std::size_t count = 0;
  if (!any()) return count;
  for (std::optional<LinkEnd>& end : ends_) {
    if (count == packets.size()) break;
    if (!end || end->sinceSent < end->terms.parameters.packetPeriod - 0.5 * end->terms.parameters.period)
      continue;
    packets[count++] = {end->terms.id, end->link.packet(now_)};
    end->sinceSent = 0.0;
  }
  ASSERT(count <= packets.size());

  return count;
}

/// A site that is too far away for a link simulates the whole part; a hub shares the part with the sites that
/// are near enough.
assets::MassProperties ReplicaLinks::shareOf(LinkedPart& linked) {
  int live = 0, apart = 0;
  double added = 0.0, lever = 0.0;
  forEachEnd(linked.part, [&](const LinkEnd& end) {
    if (!end.link.on()) return;
    if (end.link.regime() == LinkRegime::apart) ++apart;
    ++live;
    added += 0.5 * end.link.addedMass();
    lever = end.terms.parameters.lever;
  });
  const int simulators = live == apart ? 1 : std::max(1, linked.simulators - apart);
  linked.share = 1.0 / simulators;
  return replicaMass(linked.whole, simulators, added, lever);
}

void ReplicaLinks::setMass(LinkedPart& linked, RigidBody& body, double dt) {
  const assets::MassProperties target = shareOf(linked);
  if (body.mass == target.mass && body.inertia == target.inertia) return;
  linked.ramp.advance(body, target, dt);
  if (std::abs(body.mass - target.mass) > 1e-9 * target.mass) return;
  body.mass = target.mass;  // equal to the bit: a part that is alone again is what it was
  body.inertia = target.inertia;
}

LinkPull ReplicaLinks::pull(PartId part, RigidBody& body, bool held, double now, double dt) {
  now_ = now;
  ASSERT(find(part) != nullptr);
  LinkedPart& linked = *find(part);
  setMass(linked, body, dt);
  const Pose centre = centreOf(body);
  const Twist twist{velocityAt(body.worldFromBody, body.twist, centre.position), body.twist.angular};
  LinkPull sum;
  forEachEnd(part, [&](LinkEnd& end) {
    if (end.terms.outageSpring) end.link.setLongestDelay(longestDelay(held));
    const LinkPull pull = end.link.pull(now, centre, twist);
    if (end.terms.outageSpring || end.outageSpring.share() > 0.0) {
      OutageSpring::Target target = OutageSpring::targetOf(end.link, now, held);
      target.wanted = target.wanted && end.terms.outageSpring;
      end.outageSpring.advance(centre, twist, target, end.terms.parameters.lever, dt);
    }
    sum.held = sum.held + pull.held;
    sum.damping += pull.damping;
    sum.rotDamping += pull.rotDamping;
    end.sinceSent += dt;
  });
  return sum;
}

double ReplicaLinks::playOutDelay(PartId part) const {
  double longest = 0.0;
  for (const std::optional<LinkEnd>& end : ends_)
    if (end && end->terms.id.part == part && end->link.regime() != LinkRegime::apart)
      longest = std::max(longest, end->link.delay());
  return longest;
}

const OutageSpring* ReplicaLinks::outageSpring(PartId part) const {
  for (const std::optional<LinkEnd>& end : ends_)
    if (end && end->terms.id.part == part && end->outageSpring.share() > 0.0) return &end->outageSpring;
  return nullptr;
}

void ReplicaLinks::account(PartId part, const RigidBody& body, const glm::dvec3& velocity,
                           const glm::dvec3& spin, const Wrench& outagePull) {
  const Pose centre = centreOf(body);
  bool isLinked = false;
  for (std::optional<LinkEnd>& end : ends_) {
    if (!end || end->terms.id.part != part) continue;
    end->acting = end->link.account(centre, {velocity, spin});
    const double torque = glm::length(end->acting.torque) / end->terms.parameters.lever;
    const bool left =
        end->outageSpring.share() > 0.0 || std::max(glm::length(end->acting.force), torque) > kForceLeft;
    end->outagePull = end->outageSpring.share() > 0.0 ? outagePull : Wrench{};
    if (!end->link.on() && !left)
      end.reset();
    else
      isLinked = true;
  }
  ASSERT(find(part) != nullptr);
  LinkedPart& linked = *find(part);
  if (!isLinked && body.mass == linked.whole.mass && body.inertia == linked.whole.inertia) drop(linked);
}

LinkReport ReplicaLinks::report(PartId part) const {
  LinkReport report;
  const LinkedPart* linked = any() ? find(part) : nullptr;
  if (linked == nullptr) return report;
  report.share = linked->share;
  for (const std::optional<LinkEnd>& end : ends_) {
    if (!end || end->terms.id.part != part) continue;
    const CoordinationLink& link = end->link;
    report.fade = report.count == 0 ? link.fade() : std::min(report.fade, link.fade());
    ++report.count;
    report.regime = std::max(report.regime, link.regime());
    report.fresh = report.fresh && link.fresh();
    report.delay = std::max(report.delay, link.delay());
    report.pull.force += end->acting.force;
    report.pull.torque += end->acting.torque;
    report.outagePull.force += end->outagePull.force;
    report.outagePull.torque += end->outagePull.torque;
    report.work += link.account().work;
    report.borrowed += link.account().borrowed;
  }
  return report;
}

}  // namespace tandem::haptics
