#include "haptics/held_part.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace tandem::haptics {
namespace {

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

Wrench sum(const Wrench& a, const Wrench& b) { return {a.force + b.force, a.torque + b.torque}; }

/// One step of a part that is a control; the wrench on the hand if that holds it.
Wrench stepControlled(SimulatedPart& entry, const DeviceSample* device, const CouplingGains& gains,
                      double dt) {
  Wrench onHand;
  if (entry.held && device != nullptr) {
    onHand = stepHeld(entry.moved, entry.bodyFromGrip, *device, gains, dt, entry.body.worldFromBody,
                      entry.body.twist);
  } else {
    stepFree(entry.moved, dt, entry.body.worldFromBody, entry.body.twist);
  }
  entry.sinceLetGo = !entry.held && isQuiet(entry.moved) ? entry.sinceLetGo + dt : 0.0;
  return onHand;
}

}  // namespace

bool HeldParts::own(const ContactWorld& world, PartId part) {
  if (owns(part)) return true;
  if (count_ == kMaxOwnedParts) return false;
  SimulatedPart& entry = parts_[static_cast<std::size_t>(count_++)];
  entry = SimulatedPart{};
  entry.part = part;
  entry.body = bodyOf(world, part);
  entry.sinceLetGo = kSettleTime;
  entry.moved = takeControl(world, part);
  if (entry.moved.control != nullptr) entry.sinceLetGo = 0.0;  // its springs may move it from here
  return true;
}

void HeldParts::disown(PartId part) {
  SimulatedPart* entry = find(part);
  if (entry == nullptr) return;
  // Order is kept: it is the order in which the output lists them.
  for (SimulatedPart* next = entry + 1; next != parts_.data() + count_; ++next) *(next - 1) = *next;
  --count_;
}

bool HeldParts::grasp(PartId part, const Pose& worldFromDevice) {
  SimulatedPart* entry = find(part);
  if (entry == nullptr) return false;
  letGo();
  entry->held = true;
  entry->bodyFromGrip = inverse(entry->body.worldFromBody) * worldFromDevice;
  return true;
}

void HeldParts::letGo() {
  for (SimulatedPart& entry : parts_) {
    if (entry.held) entry.sinceLetGo = 0.0;
    entry.held = false;
  }
}

void HeldParts::load(PartId part, const AxisLoad& tool) {
  if (SimulatedPart* entry = find(part)) entry->moved.tool = tool;
}

Wrench HeldParts::step(const DeviceSample* device, const TickParameters& parameters,
                       const assets::Scene& scene) {
  Wrench onHand;
  for (int i = 0; i < count_; ++i) {
    SimulatedPart& entry = parts_[static_cast<std::size_t>(i)];
    const CouplingGains gains{parameters.graspStiffness, parameters.graspDamping,
                              parameters.graspRotStiffness, parameters.graspRotDamping};
    if (entry.moved.control != nullptr) {
      onHand = sum(onHand, stepControlled(entry, device, gains, parameters.dt));
      continue;
    }
    if (entry.held && device != nullptr) {
      const glm::dvec3 gravity = parameters.gravity * scene.parts[entry.part].gravityFactor;
      onHand = stepCoupledBody(entry.body, entry.bodyFromGrip, device->worldFromDevice, device->twist, gains,
                               gravity, parameters.dt);
      continue;
    }
    // Without a hand to pull it (let go, or the sample was lost) a part comes to rest where it is.
    const double decay = std::exp(-parameters.dt / kSettleDecay);
    entry.body.twist.linear *= decay;
    entry.body.twist.angular *= decay;
    if (!entry.held) entry.sinceLetGo += parameters.dt;
    if (atRest(entry)) entry.body.twist = Twist{};
    if (entry.body.twist.linear != glm::dvec3(0.0) || entry.body.twist.angular != glm::dvec3(0.0)) {
      entry.body.worldFromBody = integrate(entry.body.worldFromBody, entry.body.twist, parameters.dt);
    }
  }
  return onHand;
}

PartId HeldParts::held() const {
  for (const SimulatedPart& entry : parts()) {
    if (entry.held) return entry.part;
  }
  return kNoPart;
}

bool HeldParts::owns(PartId part) const {
  for (const SimulatedPart& entry : parts()) {
    if (entry.part == part) return true;
  }
  return false;
}

SimulatedPart* HeldParts::find(PartId part) {
  for (int i = 0; i < count_; ++i) {
    if (parts_[static_cast<std::size_t>(i)].part == part) return &parts_[static_cast<std::size_t>(i)];
  }
  return nullptr;
}

}  // namespace tandem::haptics
