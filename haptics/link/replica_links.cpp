#include "haptics/link/replica_links.h"

#include <algorithm>
#include <cmath>
#include <limits>
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
  const bool isNew = slot == nullptr;
  if (isNew) {
    slot = std::find_if(ends_.begin(), ends_.end(), [](const auto& end) { return !end.has_value(); });
    if (slot == ends_.end()) return false;
    if (find(terms.id.part) == nullptr) {
      if (parts_.full()) return false;
      parts_.push_back({terms.id.part, 1, {body.mass, body.centreOfMass, body.inertia}, {}, 1.0});
    }
    slot->emplace(terms);
    if (terms.firstFadeTime > 0.0) (*slot)->outageSpring.beginFree();
  }
  LinkEnd& end = **slot;
  end.heardAt = now_;
  end.terms.outageSpring = terms.outageSpring;
  // The outage spring of the part passes on to the link with the new owner.
  if (terms.outageSpring)
    forEachEnd(terms.id.part, [&](LinkEnd& other) {
      if (&other != &end && other.outageSpring.share() > 0.0)
        end.outageSpring = std::exchange(other.outageSpring, {});
    });
  end.link.setLongestDelay(terms.parameters.longestDelay);
  end.link.setImpedance(terms.parameters.impedance, terms.parameters.softImpedance);
  const double firstFadeTime = isNew ? terms.firstFadeTime : 0.0;
  end.link.begin(terms.epoch, terms.delay, firstFadeTime, firstFadeTime > 0.0 && terms.outageSpring);
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
  if (slot == nullptr || !(*slot)->link.receive(packet.packet)) return false;
  (*slot)->heardAt = now_;
  return true;
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

std::size_t ReplicaLinks::drainDoubts(std::span<LinkId> doubts) {
  std::size_t count = 0;
  if (!any()) return count;
  for (std::optional<LinkEnd>& end : ends_) {
    if (count == doubts.size()) break;
    if (end && end->link.drainDoubt()) doubts[count++] = end->terms.id;
  }
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

void ReplicaLinks::setMass(LinkedPart& linked, RigidBody& body, bool grasped, double dt) {
  const assets::MassProperties target = shareOf(linked);
  if (body.mass == target.mass && body.inertia == target.inertia) return;
  int ends = 0, newEnds = 0;
  forEachEnd(linked.part, [&](const LinkEnd& end) {
    ++ends;
    if (end.terms.outageSpring && end.terms.firstFadeTime > 0.0 && !end.hasFadedIn) ++newEnds;
  });
  if (!grasped && ends > 0 && newEnds == ends) {  // no hand has pulled at this replica yet: it begins light
    const double light = std::min(1.0, kMinReplicaMass / target.mass);
    changeMass(body, {light * target.mass, target.centreOfMass, light * target.inertia},
               std::numeric_limits<double>::infinity());
  } else {
    linked.ramp.advance(body, target, dt);
  }
  if (std::abs(body.mass - target.mass) > 1e-9 * target.mass) return;
  body.mass = target.mass;  // equal to the bit: a part that is alone again is what it was
  body.inertia = target.inertia;
}

bool ReplicaLinks::knows(PartId part) const {
  const auto ordered = [part](const LinkTerms& terms) { return terms.id.part == part; };
  return has(part) || std::any_of(orders_.begin(), orders_.end(), ordered);
}

bool ReplicaLinks::carry(PartId part) const {
  if (!has(part)) return !knows(part);
  return std::all_of(ends_.begin(), ends_.end(), [part](const std::optional<LinkEnd>& end) {
    return !end || end->terms.id.part != part || !end->terms.outageSpring || end->link.carries() ||
           end->link.regime() == LinkRegime::apart;
  });
}

LinkPull ReplicaLinks::pull(PartId part, RigidBody& body, Holding holding, double now, double dt) {
  now_ = now;
  ASSERT(find(part) != nullptr);
  LinkedPart& linked = *find(part);
  setMass(linked, body, holding.grasped, dt);
  const Pose centre = centreOf(body);
  const Twist twist{velocityAt(body.worldFromBody, body.twist, centre.position), body.twist.angular};
  LinkPull sum;
  forEachEnd(part, [&](LinkEnd& end) {
    if (end.terms.outageSpring) end.link.setLongestDelay(longestDelay(holding.held));
    end.link.setHeld(holding.held);
    const LinkPull pull = end.link.pull(now, centre, twist);
    if (end.terms.outageSpring || end.outageSpring.share() > 0.0) {
      OutageSpring::Target target = OutageSpring::targetOf(end.link, now, holding.grasped);
      target.wanted = target.wanted && end.terms.outageSpring;
      target.most = end.link.leftToLead();
      end.outageSpring.advance(centre, twist, target, end.terms.parameters.lever, dt);
    }
    sum.held = sum.held + pull.held;
    sum.damping += pull.damping;
    sum.rotDamping += pull.rotDamping;
    if (holding.grasped) end.terms.outageSpring = false;
    end.hasFadedIn = end.hasFadedIn || end.link.acts();
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

namespace {

void forgetState(LinkReport& report) {
  report.regime = LinkRegime::stiff;
  report.fade = 1.0;
  report.fresh = report.heard = true;
  report.delay = 0.0;
}

/// Adds the state of a link whose peer has been silent for `silence` s.
void addState(const CoordinationLink& link, double silence, LinkReport& report) {
  report.fade = std::min(report.fade, link.fade());
  report.regime = std::max(report.regime, link.regime());
  report.fresh = report.fresh && link.fresh();
  report.delay = std::max(report.delay, link.delay());
  report.heard = report.heard && silence < kLinkSilence;
}

}  // namespace

LinkReport ReplicaLinks::report(PartId part) const {
  LinkReport report;
  const LinkedPart* linked = any() ? find(part) : nullptr;
  if (linked == nullptr) return report;
  report.share = linked->share;
  forgetState(report);
  for (const std::optional<LinkEnd>& end : ends_) {
    if (!end || end->terms.id.part != part) continue;
    const CoordinationLink& link = end->link;
    ++report.count;
    if (link.on() && report.live++ == 0) forgetState(report);  // an ending link counts only beside none
    if (link.on() || report.live == 0) addState(link, now_ - end->heardAt, report);
    report.pull.force += end->acting.force;
    report.pull.torque += end->acting.torque;
    report.outagePull.force += end->outagePull.force;
    report.outagePull.torque += end->outagePull.torque;
    report.work += link.account().work;
    report.borrowed += link.account().borrowed;
  }
  if (report.count == 0) report.fade = 0.0;
  return report;
}

}  // namespace tandem::haptics
