#include "haptics/grasp/held_part.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace tandem::haptics {
namespace {

constexpr double kClosingTime = 0.5;   // s, in which a hand closes on a part that other sites hold too
constexpr double kLongestWait = 1.0;   // s, for the link that is to carry the part before
constexpr double kDampingTime = 0.05;  // s, in which the damper of a grip comes

/// Mass properties fit for integration. Where the scene has none, or an inertia that no body can have, those
/// of a ball of aluminium of half the part's extent: heavy enough to feel, and of the right order in every
/// unit.
RigidBody bodyOf(const ContactWorld& world, PartId part) {
  const assets::MassProperties& given = world.scene().parts[part].massProperties;
  const Collider& collider = world.collider(part);
  const double radius = collider.radius > 0.0 ? 0.5 * collider.radius : 0.01;
  RigidBody body;
  const bool known = given.mass > 0.0;
  body.mass = known ? given.mass : 2700.0 * 4.18879 * radius * radius * radius;
  body.centreOfMass = known ? given.centreOfMass : collider.centre;
  const glm::dmat3& i = given.inertia;
  const double minor = i[0][0] * i[1][1] - i[0][1] * i[1][0];
  const bool definite = i[0][0] > 0.0 && minor > 0.0 && glm::determinant(i) > 0.0;
  body.inertia = definite && known ? i : glm::dmat3(0.4 * body.mass * radius * radius);
  body.worldFromBody = world.pose(part);
  return body;
}

/// Whether a hand with a valid reading pulls at a part.
bool isPulled(const SimulatedPart& entry, const HandPulls& hands) {
  for (std::size_t h = 0; h < kHands; ++h) {
    if (entry.grips[h].holds && hands[h].device != nullptr) return true;
  }
  return false;
}

/// Stiffness of a grasp as a share of its full one. It begins with a slope of zero: a part that moves when it
/// is taken is caught gradually.
double stiffnessAt(double firmness) { return firmness * firmness; }

CouplingGains firm(CouplingGains gains, double firmness) {
  const double share = stiffnessAt(firmness);
  gains.stiffness *= share;
  gains.damping *= share;
  gains.rotStiffness *= share;
  gains.rotDamping *= share;
  return gains;
}

/// Closes the fingers of a hand a little further; they stay open for a while if nothing carries the part yet.
/// As the spring becomes stiffer it keeps its force, so that it receives no energy: the grip moves towards
/// the device.
void close(Grip& grip, const Pose& worldFromBody, const Pose& worldFromDevice, bool carried, double dt) {
  const double before = stiffnessAt(grip.firmness);
  grip.waited += dt;
  if (grip.firmness == 0.0 && !carried && grip.waited < kLongestWait) {
    grip.bodyFromGrip = inverse(worldFromBody) * worldFromDevice;
    return;
  }
  grip.firmness = std::min(1.0, grip.firmness + dt / kClosingTime);
  const Pose worldFromGrip =
      interpolate(worldFromDevice, worldFromBody * grip.bodyFromGrip, before / stiffnessAt(grip.firmness));
  grip.bodyFromGrip = inverse(worldFromBody) * worldFromGrip;
}

/// One step of a part that is a control; adds what the hand that holds it feels.
void stepControlled(SimulatedPart& entry, const HandPulls& hands, double dt,
                    std::array<Wrench, kHands>& onHands) {
  bool pulled = false;
  for (std::size_t h = 0; h < kHands && !pulled; ++h) {
    Grip& grip = entry.grips[h];
    pulled = grip.holds && hands[h].device != nullptr;
    if (!pulled) continue;
    grip.onHand = stepHeld(entry.moved, grip.bodyFromGrip, *hands[h].device, hands[h].gains, dt,
                           entry.body.worldFromBody, entry.body.twist);
    onHands[h] = onHands[h] + grip.onHand;
  }
  if (!pulled) stepFree(entry.moved, dt, entry.body.worldFromBody, entry.body.twist);
  entry.sinceLetGo = !entry.held() && isQuiet(entry.moved) ? entry.sinceLetGo + dt : 0.0;
}

/// Ends the step of a control that parts may push.
void endControlled(SimulatedPart& entry, const MovingPart& moving, const PartContact& contact, double dt) {
  endGuided(entry.moved, moving.displacement, dt, entry.body.worldFromBody, entry.body.twist);
  entry.moved.pushed = contact.presses(entry.part);
  entry.sinceLetGo = isQuiet(entry.moved) ? entry.sinceLetGo + dt : 0.0;
}

/// What pulls a part down, m/s^2.
glm::dvec3 gravityOn(PartId part, const TickParameters& parameters, const assets::Scene& scene) {
  return parameters.gravity * scene.parts[part].gravityFactor;
}

/// What fades of the pull of a hand that has let go, about the centre of mass.
Wrench endedPull(SimulatedPart& entry, double dt) {
  if (!entry.ended.active()) return {};
  const RigidBody& body = entry.body;
  const glm::dvec3 at = transformPoint(body.worldFromBody, entry.endedAt);
  entry.ended.advance(dt * velocityAt(body.worldFromBody, body.twist, at), dt * body.twist.angular, dt);
  const Wrench now = entry.ended.now();
  const glm::dvec3 arm = at - transformPoint(body.worldFromBody, body.centreOfMass);
  return {now.force, now.torque + glm::cross(arm, now.force)};
}

// s after its last contact in which a part may still begin to slip. By then the spring of its hand has set it
// in motion, unless it is so heavy that it moves slowly.
constexpr double kSlipTime = 0.1;
constexpr double kFar = 0.15;          // s, of play-out
constexpr double kRoundingTime = 0.5;  // s
constexpr double kShort = 0.1;         // of the stretch at the limit: rounding takes 0.5 % of the force

/// What other sites have to do with a part in the hand.
struct Tie {
  bool tied = false;    // they simulate it too
  bool far = false;     // at least one of them is beyond kFar
  double weight = 0.0;  // N, of the replica here
};

/// The share of its stiffness, 0..1, that a spring keeps where its force would be `asked` times its limit. It
/// is the kinked law at `rounded` 0 and the rounded one at 1.
double limitedShare(double asked, double rounded) {
  const double kinked = std::min(1.0, 1.0 / std::max(asked, 1e-300));
  const double round = 1.0 / std::sqrt(1.0 + asked * asked);
  return kinked + rounded * (round - kinked);
}

/// A hand's coupling to a part.
///
/// Beyond the force that the device can give, the hand would stretch the spring without paying for it, and
/// other sites' hands would be given that energy. So the spring of a tied part gives the part no more than
/// that, and the part's weight, which the hand need not feel: it is linear up to the limit, then of constant
/// force (Huber's function as its potential), so it stores what the hand has paid.
///
/// The same holds for the torque, and there for spring and damper together. On a device that drives no torque
/// a person turns as far and as fast as they like and feels nothing of it. The torque limit then stands for
/// what such a hand may put on the part.
///
/// Where others are far, a pushed row yields long before their resistance comes back, and runs after the hand
/// while the spring is beyond its limit. The kink of the force would then be a step to the hand, so it is
/// rounded: F = limit s / sqrt(1 + s^2), s the stretch as a share of that at the limit. Rounding comes
/// gradually, which only takes energy. A part that is tied no longer keeps limit and rounding until its
/// spring is short, so that nothing jumps.
Coupling couplingOf(Grip& grip, const HandPull& hand, const RigidBody& body, const Tie& tie, double dt) {
  const DeviceSample& device = *hand.device;
  CouplingGains gains = firm(hand.gains, grip.firmness);
  grip.damped = std::min(1.0, grip.damped + dt / kDampingTime);
  gains.damping *= grip.damped;
  gains.rotDamping *= grip.damped;
  Coupling coupling{grip.bodyFromGrip, device.worldFromDevice, device.twist, gains};
  const bool mayBeLimited = tie.tied || grip.limited || grip.rounded > 0.0;
  if (!mayBeLimited || !(hand.forceLimit > 0.0)) return coupling;
  const Pose worldFromGrip = body.worldFromBody * grip.bodyFromGrip;
  const double gap = glm::length(device.worldFromDevice.position - worldFromGrip.position);
  const glm::dvec3 angle =
      rotationVector(device.worldFromDevice.orientation * glm::conjugate(worldFromGrip.orientation));
  const glm::dvec3 torque =
      gains.rotStiffness * angle + gains.rotDamping * (device.twist.angular - body.twist.angular);
  const double arm =
      glm::length(worldFromGrip.position - transformPoint(body.worldFromBody, body.centreOfMass));
  // The spring's force and the torque of spring and damper, each divided by its limit.
  const double stretch = gains.stiffness * gap / (hand.forceLimit + tie.weight);
  const double twist = glm::length(torque) / (hand.torqueLimit + arm * tie.weight);
  const double most = std::max(stretch, twist);
  grip.limited = tie.tied || (grip.limited && most > 1.0);
  grip.rounded =
      tie.far ? std::min(1.0, grip.rounded + dt / kRoundingTime) : (most > kShort ? grip.rounded : 0.0);
  if (!grip.limited && grip.rounded == 0.0) return coupling;
  const double turningShare = limitedShare(twist, grip.rounded);
  coupling.gains.stiffness *= limitedShare(stretch, grip.rounded);
  coupling.gains.rotStiffness *= turningShare;
  coupling.gains.rotDamping *= turningShare;
  return coupling;
}

/// The tool's spring, as if it held the part where it presses: so it is implicit, and any mass is stable.
Coupling couplingOf(const ToolPush& tool, const Pose& worldFromBody) {
  const Pose grip{tool.point, worldFromBody.orientation};
  return {inverse(worldFromBody) * grip,
          {grip.position + tool.force / tool.stiffness, grip.orientation},
          {},
          {tool.stiffness, 0.0, 0.0, 0.0}};
}

/// What a link's force falls by as the part moves: a coupling without a spring at the centre of mass.
Coupling couplingOf(const LinkPull& link, const RigidBody& body) {
  const Pose bodyFromCentre{body.centreOfMass, {1.0, 0.0, 0.0, 0.0}};
  return {bodyFromCentre, body.worldFromBody * bodyFromCentre, {}, {0.0, link.damping, 0.0, link.rotDamping}};
}

/// The implicit part of the fields' force: a coupling that pulls at nothing where the part is. Its spring is
/// as stiff as the field's curvature, so that no step ends with more energy than it began with, as in
/// control_dynamics.h. Its damper is that of the fields: at the present velocity it gives their drag, and it
/// grows with the velocity of the step.
Coupling couplingOf(const FieldPull& field, const RigidBody& body) {
  const Pose bodyFromCentre{body.centreOfMass, {1.0, 0.0, 0.0, 0.0}};
  const Pose centre = body.worldFromBody * bodyFromCentre;
  Twist carried;
  if (field.dampingRate > 0.0)
    carried.linear =
        velocityAt(body.worldFromBody, body.twist, centre.position) + field.damping / field.dampingRate;
  return {bodyFromCentre, centre, carried, {field.curvature, field.dampingRate, 0.0, 0.0}};
}

/// Radius of gyration, m: the size of a body to itself.
double sizeOf(const RigidBody& body) {
  const glm::dmat3& i = body.inertia;
  return std::sqrt((i[0][0] + i[1][1] + i[2][2]) / (2.0 * body.mass));
}

/// Whether a part has fallen out of its scene.
bool isLost(const RigidBody& body, const assets::Scene& scene) {
  const glm::dvec3 size = scene.bounds.max - scene.bounds.min,
                   middle = 0.5 * (scene.bounds.max + scene.bounds.min);
  return glm::length(body.worldFromBody.position - middle) > 10.0 * glm::length(size);
}

}  // namespace

bool SimulatedPart::grasped() const {
  return std::any_of(grips.begin(), grips.end(),
                     [](const Grip& grip) { return grip.holds && grip.firmness > 0.0; });
}

bool HeldParts::own(const ContactWorld& world, PartId part, bool awake, const Twist& twist) {
  if (owns(part)) return true;
  if (parts_.full()) return false;
  SimulatedPart& entry = parts_.push_back({});
  entry.part = part;
  entry.body = bodyOf(world, part);
  entry.body.twist = twist;
  const bool moves = twist.linear != glm::dvec3(0.0) || twist.angular != glm::dvec3(0.0);
  entry.sinceLetGo = awake || moves ? 0.0 : kSettleTime;
  entry.restPose = entry.body.worldFromBody;
  entry.moved = takeControl(world, part, entry.body);
  if (entry.moved.control != nullptr) entry.sinceLetGo = 0.0;  // its springs may move it from here
  return true;
}

void HeldParts::disown(PartId part) {
  SimulatedPart* entry = find(part);
  if (entry == nullptr) return;
  links_.forget(part);
  parts_.erase(parts_.begin() + (entry - parts_.data()));  // in order, which is that of the output
}

bool HeldParts::grasp(PartId part, const Pose& worldFromDevice, const TickParameters& parameters, int hand) {
  SimulatedPart* entry = find(part);
  if (entry == nullptr) return false;
  const auto index = static_cast<std::size_t>(hand);
  if (entry->moved.control != nullptr && entry->grips[1 - index].holds) return false;
  letGo(parameters, hand);
  if (hand == 0) entry->tool = ToolPush{};  // the tool does not touch what its own hand holds
  const double firmness = links_.knows(part) ? 0.0 : 1.0;
  const Pose bodyFromGrip = inverse(entry->body.worldFromBody) * worldFromDevice;
  entry->grips[index] = {true, false, 0.0, bodyFromGrip, {}, firmness, 0.0};
  return true;
}

bool HeldParts::letGo(const TickParameters& parameters, int hand) {
  for (SimulatedPart& entry : parts_) {
    Grip& grip = entry.grips[static_cast<std::size_t>(hand)];
    if (!grip.holds) continue;
    grip.holds = false;
    entry.tool = ToolPush{};
    if (!entry.held()) {
      entry.sinceLetGo = 0.0;
      entry.restPose = entry.body.worldFromBody;
    }
    if (entry.held() || links_.has(entry.part)) {
      // Part and hand receive half each of the energy of the spring, as from two springs of twice the
      // stiffness.
      entry.ended.start({-grip.onHand.force, -grip.onHand.torque},
                        {2.0 * parameters.graspStiffness, 2.0 * parameters.graspRotStiffness},
                        parameters.fadeTime);
      entry.endedAt = grip.bodyFromGrip.position;
      return true;
    }
    entry.ended = Fade{};
    return false;
  }
  return false;
}

bool HeldParts::beginLink(const LinkTerms& terms) {
  const SimulatedPart* const entry = find(terms.id.part);
  if (entry == nullptr || entry->moved.control != nullptr) return false;
  return links_.begin(terms, entry->body);
}

void HeldParts::load(PartId part, const AxisLoad& tool) {
  if (SimulatedPart* entry = find(part)) entry->moved.tool = tool;
}

bool HeldParts::isFree(PartId part, const glm::dvec3& gravity, const PartContact* contact) {
  if (contact == nullptr) return false;
  return contact->joined(part) || (contact->collides(part) && gravity != glm::dvec3(0.0));
}

void HeldParts::noteRest(SimulatedPart& entry, double dt) {
  const double size = sizeOf(entry.body);
  const Pose &now = entry.body.worldFromBody, &then = entry.restPose;
  const double displacement =
      glm::length(now.position - then.position) +
      size * glm::length(rotationVector(now.orientation * glm::conjugate(then.orientation)));
  entry.sinceLetGo += dt;
  if (displacement < 1e-3 * size) return;
  entry.sinceLetGo = 0.0;
  entry.restPose = now;
}

bool HeldParts::freeStep(SimulatedPart& entry, const glm::dvec3& gravity, double dt,
                         const PartContact* contact, const assets::Scene& scene, CoupledStep& step) {
  const bool free = isFree(entry.part, gravity, contact);
  if (free) {
    if (atRest(entry) && contact->disturbed(entry.part)) entry.sinceLetGo = 0.0;
    if (isLost(entry.body, scene)) entry.sinceLetGo = kSettleTime;
  } else if (!entry.held()) {
    entry.sinceLetGo += dt;
  }
  if (atRest(entry)) entry.body.twist = Twist{};
  const bool attracted = entry.attracted.force != glm::dvec3(0.0);
  if (free && (attracted || entry.tool.stiffness > 0.0)) {
    entry.sinceLetGo = 0.0;
    FixedVector<Coupling, 1> tool;
    if (entry.tool.stiffness > 0.0) tool.push_back(couplingOf(entry.tool, entry.body.worldFromBody));
    step = coupleBody(entry.body, {tool.data(), tool.size()}, entry.attracted, gravity, dt);
    return true;
  }
  const bool awake = free && !atRest(entry);
  if (!awake && isStill(entry.body.twist)) return false;
  const bool falls = free && gravity != glm::dvec3(0.0);
  step = coast(entry.body, falls ? 1.0 : std::exp(-dt / kSettleDecay));
  if (awake) step.freeVelocity += dt * gravity;
  return true;
}

void HeldParts::push(PartId part, const ToolPush& tool) {
  if (SimulatedPart* entry = find(part)) entry->tool = tool;
}

void HeldParts::pull(PartId part, const FieldPull& field) {
  if (SimulatedPart* entry = find(part)) entry->field = field;
}

void HeldParts::attract(PartId part, const Wrench& magnet) {
  if (SimulatedPart* entry = find(part)) entry->attracted = entry->attracted + magnet;
}

void HeldParts::forgetMagnets() {
  for (SimulatedPart& entry : parts_) entry.attracted = Wrench{};
}

void HeldParts::rub(PartId part, const Wrench& surfaces) {
  if (SimulatedPart* entry = find(part)) entry->rubbed = surfaces;
}

bool HeldParts::pulledStep(SimulatedPart& entry, const HandPulls& hands, const TickParameters& parameters,
                           const glm::dvec3& gravity, double now, MovingPart& moving) {
  const double dt = parameters.dt;
  std::array<Coupling, kMaxCouplings> couplings;
  std::size_t count = 0;
  const bool linked = links_.has(entry.part);
  const Tie tie{linked, linked && links_.playOutDelay(entry.part) > kFar,
                entry.body.mass * glm::length(gravity)};
  FixedVector<glm::dvec3, kHands> last;  // N, of the springs on the hands
  for (std::size_t h = 0; h < kHands; ++h) {
    Grip& grip = entry.grips[h];
    const Wrench lastOnHand = std::exchange(grip.onHand, Wrench{});
    if (!grip.holds || hands[h].device == nullptr) continue;
    if (grip.firmness < 1.0)
      close(grip, entry.body.worldFromBody, hands[h].device->worldFromDevice, links_.carry(entry.part), dt);
    couplings[count++] = couplingOf(grip, hands[h], entry.body, tie, dt);
    last.push_back(lastOnHand.force - grip.felt.last());
  }
  if (count == 0 && !linked) return false;
  const bool held = count > 0;
  Wrench load = endedPull(entry, dt) + (held ? entry.rubbed : Wrench{}) + entry.attracted;
  double weighs = 1.0;
  if (linked) {
    const LinkPull link = links_.pull(entry.part, entry.body, {held, entry.grasped()}, now, dt);
    load = load + link.held;
    couplings[count++] = couplingOf(link, entry.body);
    if (const OutageSpring* spring = links_.outageSpring(entry.part)) {
      couplings[count++] = spring->coupling(entry.body);
      weighs -= spring->share();
    }
    entry.sinceLetGo = 0.0;
  }
  if (entry.tool.stiffness > 0.0) couplings[count++] = couplingOf(entry.tool, entry.body.worldFromBody);
  if (held && entry.field.acts()) {
    load.force += entry.field.force;
    couplings[count++] = couplingOf(entry.field, entry.body);
  }
  moving.step = coupleBody(entry.body, {couplings.data(), count}, load, weighs * gravity, dt);
  // A part that another site or a tool moves too goes as fast as they move it.
  const bool movedByOthers = linked || entry.tool.stiffness > 0.0;
  if (!entry.slips || movedByOthers || !(parameters.slipChange > 0.0)) return true;
  const double handWay = std::max(hands[0].way, hands[1].way);
  const glm::dvec3 com = transformPoint(entry.body.worldFromBody, entry.body.centreOfMass);
  for (std::size_t i = 0; i < last.size(); ++i) {
    const CouplingForce& pull = moving.step.couplings[i];
    const double gripWay =
        dt * glm::length(velocityAt(entry.body.worldFromBody, entry.body.twist, com + pull.arm));
    moving.grips.push_back(paceOf({pull.arm, last[i], pull.force - pull.damping * couplings[i].device.linear,
                                   couplings[i].gains.stiffness, gripWay, handWay},
                                  parameters.slipChange));
  }
  return true;
}

void HeldParts::react(SimulatedPart& entry, const HandPulls& hands, const CoupledStep& step,
                      const glm::dvec3& velocity, const glm::dvec3& spin, bool touches, double slipChange,
                      std::array<Wrench, kHands>& onHands) {
  std::size_t coupling = 0;
  for (std::size_t h = 0; h < kHands; ++h) {
    Grip& grip = entry.grips[h];
    if (!grip.holds || hands[h].device == nullptr) continue;
    const CouplingForce& pull = step.couplings[coupling++];
    const glm::dvec3 atGrip = pull.gripVelocity(velocity, spin), &ofHand = hands[h].device->twist.linear;
    grip.onHand = pull.onHand(velocity, spin);
    grip.onHand.force +=
        grip.felt.force(pull.damping, atGrip, ofHand, touches, slipChange) - pull.damping * (atGrip - ofHand);
    onHands[h] = onHands[h] + grip.onHand;
  }
  if (!links_.has(entry.part)) return;
  const Wrench back =
      step.couplings[coupling + 1].onHand(velocity, spin);  // of what leads it: after the links'
  links_.account(entry.part, entry.body, velocity, spin, {-back.force, -back.torque});
}

void HeldParts::take(PartContact& contact, const TickParameters& parameters) {
  for (const SimulatedPart& entry : parts_) {
    const RigidBody& body = entry.body;
    const double size = sizeOf(body);
    const bool still = glm::length(body.twist.linear) + size * glm::length(body.twist.angular) <=
                       PartContact::kRestShare * size;
    if (!still || entry.moved.control != nullptr || links_.has(entry.part)) contact.hurry(entry.part);
  }
  contact.take(parameters.dt, parameters.effort);
}

void HeldParts::stand(SimulatedPart& entry, const HandPulls& hands) {
  entry.body.twist = Twist{};
  for (std::size_t h = 0; h < kHands; ++h) {
    Grip& grip = entry.grips[h];
    if (!grip.holds) continue;
    grip.onHand = Wrench{};
    grip.felt = FeltDamper{};
    grip.damped = 0.0;
    if (hands[h].device != nullptr)
      grip.bodyFromGrip = inverse(entry.body.worldFromBody) * hands[h].device->worldFromDevice;
  }
}

std::array<Wrench, kHands> HeldParts::step(const HandPulls& hands, const TickParameters& parameters,
                                           const assets::Scene& scene, PartContact* contact, double now) {
  std::array<Wrench, kHands> onHands;
  FixedVector<MovingPart, kMaxOwnedParts> moving;
  FixedVector<SimulatedPart*, kMaxOwnedParts> entries;  // of `moving`
  const double dt = parameters.dt;
  if (contact != nullptr) take(*contact, parameters);
  for (SimulatedPart& entry : parts_) {
    if (entry.moved.control != nullptr) continue;
    if (contact != nullptr && contact->isTaking(entry.part)) {
      stand(entry, hands);
      continue;
    }
    glm::dvec3 gravity = gravityOn(entry.part, parameters, scene);
    // Without a hand to pull it (let go, or the sample was lost) a part comes to rest where it is, unless
    // it is free.
    const bool falls = isPulled(entry, hands) || (!entry.held() && isFree(entry.part, gravity, contact));
    if (!falls) gravity = glm::dvec3(0.0);
    MovingPart part{entry.part, {}, &entry.body};
    const CoupledStep& step = part.step;
    if (!pulledStep(entry, hands, parameters, gravity, now, part) &&
        !freeStep(entry, gravity, dt, contact, scene, part.step))
      continue;
    if (contact != nullptr && contact->constrains(entry.part)) {
      entries.push_back(&entry);
      moving.push_back(part);
      continue;
    }
    moveBody(entry.body, step.freeVelocity, step.freeSpin, dt);
    react(entry, hands, step, step.freeVelocity, step.freeSpin, false, parameters.slipChange, onHands);
  }
  const std::size_t bodies = moving.size();  // controls follow them
  for (SimulatedPart& entry : parts_) {
    if (entry.moved.control == nullptr) continue;
    entry.moved.pushed = false;
    const double radius = contact != nullptr && !entry.held()
                              ? contact->radiusNear(entry.part, entry.body, {moving.data(), bodies}, dt)
                              : 0.0;
    if (!(radius > 0.0)) {
      stepControlled(entry, hands, dt, onHands);
      continue;
    }
    entries.push_back(&entry);
    moving.push_back(guidedPart(entry.moved, entry.body, radius, dt));
  }
  if (moving.empty()) return onHands;
  contact->move({moving.data(), moving.size()}, dt, parameters.effort);
  for (std::size_t i = bodies; i < moving.size(); ++i) endControlled(*entries[i], moving[i], *contact, dt);
  for (std::size_t i = 0; i < bodies; ++i) {
    const Displacement& displacement = moving[i].displacement;
    SimulatedPart& entry = *entries[i];
    entry.sinceTouched =
        moving[i].slips || contact->presses(entry.part) ? 0.0 : std::min(1.0, entry.sinceTouched + dt);
    const bool touches = entry.sinceTouched < kSlipTime;
    entry.slips = touches && !moving[i].cutShort;
    react(entry, hands, moving[i].step, displacement.linear / dt, displacement.angular / dt, touches,
          parameters.slipChange, onHands);
    if (!entry.held() && !links_.has(entry.part) &&
        isFree(entry.part, gravityOn(entry.part, parameters, scene), contact))
      noteRest(entry, dt);
  }
  if (moving.size() > 1) wakeTouched(*contact, parameters, scene);
  if (parts_.size() > 1) wakeJoined(*contact, parameters, scene);
  return onHands;
}

void HeldParts::wakeTouched(const PartContact& contact, const TickParameters& parameters,
                            const assets::Scene& scene) {
  for (const PartTouch& touch : contact.touches()) {
    SimulatedPart *of = find(touch.of), *on = find(touch.part);
    if (of != nullptr && on != nullptr && touch.force > 0.0)
      restTogether(*of, *on, contact, parameters, scene);
  }
}

void HeldParts::wakeJoined(const PartContact& contact, const TickParameters& parameters,
                           const assets::Scene& scene) {
  for (SimulatedPart& entry : parts_) {
    contact.forEachJoined(entry.part, [&](PartId other) {
      if (SimulatedPart* joined = find(other)) restTogether(entry, *joined, contact, parameters, scene);
    });
  }
}

void HeldParts::restTogether(SimulatedPart& a, SimulatedPart& b, const PartContact& contact,
                             const TickParameters& parameters, const assets::Scene& scene) {
  const double since = std::min(a.held() ? 0.0 : a.sinceLetGo, b.held() ? 0.0 : b.sinceLetGo);
  for (SimulatedPart* entry : {&a, &b}) {
    if (isFree(entry->part, gravityOn(entry->part, parameters, scene), &contact))
      entry->sinceLetGo = std::min(entry->sinceLetGo, since);
  }
}

PartId HeldParts::held(int hand) const {
  const SimulatedPart* const entry = heldPart(hand);
  return entry != nullptr ? entry->part : kNoPart;
}

const SimulatedPart* HeldParts::heldPart(int hand) const {
  for (const SimulatedPart& entry : parts()) {
    if (entry.grips[static_cast<std::size_t>(hand)].holds) return &entry;
  }
  return nullptr;
}

bool HeldParts::owns(PartId part) const {
  for (const SimulatedPart& entry : parts()) {
    if (entry.part == part) return true;
  }
  return false;
}

SimulatedPart* HeldParts::find(PartId part) {
  for (SimulatedPart& entry : parts_) {
    if (entry.part == part) return &entry;
  }
  return nullptr;
}

}  // namespace tandem::haptics
