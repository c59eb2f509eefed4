#include "haptics/felt_through_parts.h"

#include <algorithm>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

namespace tandem::haptics {
namespace {

using Data = TickState::Data;

// The curvature of a field is measured over no less than this.
constexpr double kLeastOver = 1e-6;  // m

/// The share of the fade time that a tick takes.
double fadeStep(const TickParameters& parameters) {
  return parameters.fadeTime > 0.0 ? parameters.dt / parameters.fadeTime : 1.0;
}

/// Whether forces may move a simulated part: a control moves along its axis alone, and a part stands still
/// while it is being taken.
bool yieldsToForces(const Data& data, const SimulatedPart& part) {
  return part.moved.control == nullptr && !data.isTaking(part.part);
}

/// The part in a hand with a valid reading if forces may move it; else null.
const SimulatedPart* pullable(const Data& data, std::size_t hand) {
  const SimulatedPart* const held = data.held.heldPart(static_cast<int>(hand));
  return held != nullptr && data.hands[hand].valid() && yieldsToForces(data, *held) ? held : nullptr;
}

/// 0..1, of what acts on a part, that is put on it here; other sites that simulate it put on the rest.
double shareHere(const Data& data, PartId part) {
  const ReplicaLinks& links = data.held.links();
  return links.has(part) ? links.report(part).share : 1.0;
}

/// Whether the first hand holds what this hand holds, so that it is pulled already.
bool isSecond(const Data& data, std::size_t hand, PartId held) {
  return hand > 0 && data.held.held(0) == held && data.hands[0].valid();
}

void pullByFields(const SimulatedPart& held, ForceFields& fields, double share, double now,
                  const TickParameters& parameters, Data& data, TickOutput& out) {
  const Pose& pose = held.body.worldFromBody;
  DeviceSample centre;
  centre.worldFromDevice.position = transformPoint(pose, held.body.centreOfMass);
  centre.twist.linear = velocityAt(pose, held.body.twist, centre.worldFromDevice.position);
  FieldSettings settings = fieldSettings(parameters, held.part);
  // What a part can do within a tick, and at rest what rounding lets the differences tell.
  settings.curvatureOver = std::max(2.0 * parameters.dt * glm::length(centre.twist.linear), kLeastOver);
  const FieldForces felt = fields.step(data.world, centre, now, settings);
  share *= shareHere(data, held.part);
  data.held.pull(held.part, {share * (felt.force - felt.damping), share * felt.damping,
                             share * felt.curvature, share * felt.dampingRate});
  out.sourcePower += share * felt.sourcePower;
  out.flags |= felt.flags;
}

glm::dmat3 mobilityOf(const RigidBody& body) {
  const glm::dmat3 turn = glm::mat3_cast(body.worldFromBody.orientation);
  return turn * glm::inverse(body.inertia) * glm::transpose(turn);
}

using MagneticBodies = FixedVector<MagneticBody, kMaxOwnedParts>;
MagneticBodies magneticBodies(const Data& data) {
  MagneticBodies bodies;
  for (const SimulatedPart& part : data.held.parts()) {
    if (!yieldsToForces(data, part)) continue;
    const glm::dvec3 centre = transformPoint(part.body.worldFromBody, part.body.centreOfMass);
    bodies.push_back({part.part, centre, part.body.mass, mobilityOf(part.body)});
  }
  return bodies;
}

/// Puts a force at a point on a part, if that moves here.
void attract(const MagneticBodies& bodies, PartId part, const glm::dvec3& force, const glm::dvec3& point,
             Data& data) {
  for (const MagneticBody& body : bodies)
    if (body.part == part) data.held.attract(part, {force, glm::cross(point - body.centre, force)});
}

HeldBody bodyUnder(const Hand& hand, const SimulatedPart& held) {
  const RigidBody& body = held.body;
  return {body.worldFromBody, body.twist,       transformPoint(body.worldFromBody, body.centreOfMass),
          body.mass,          mobilityOf(body), hand.motion(),
          hand.sentShare()};
}

/// The surfaces under what one hand holds.
void feelSurfacesUnder(const SimulatedPart& held, std::size_t hand, Data& data, TickOutput& out) {
  FixedVector<HeldTouch, PartTouches::kMax> list;
  for (const PartTouch& touch : data.partContact->touches()) {
    if (touch.of != held.part && touch.part != held.part) continue;
    const bool first = touch.of == held.part;
    const PartId other = first ? touch.part : touch.of;
    list.push_back(
        {other, touch.point, first ? touch.normal : -touch.normal, touch.force, data.held.owns(other)});
  }
  const HeldSurfaceForces felt =
      feelThrough(data.world, {list.data(), list.size()}, bodyUnder(data.hands[hand], held),
                  data.hands[hand].parameters(), data.heldSurfaces[hand]);
  data.throughPart[hand].force = felt.onHand;
  data.held.rub(held.part, felt.onPart);
  if (felt.givesWay != kNoPart) data.partContact->letPass(held.part, felt.givesWay);
  if (data.partContact->passes(held.part)) out.flags |= kFlagPopThrough;
}

}  // namespace

FieldSettings fieldSettings(const TickParameters& parameters, PartId held) {
  return {parameters.dt, parameters.fadeTime, parameters.fieldDampingLimit, held};
}

void pullByFields(double now, int hands, const TickParameters& parameters, Data& data, TickOutput& out) {
  for (std::size_t h = 0; h < static_cast<std::size_t>(hands); ++h) {
    const SimulatedPart* const held = pullable(data, h);
    double& share = data.fieldShare[h];
    share = std::clamp(share + (held != nullptr ? fadeStep(parameters) : -fadeStep(parameters)), 0.0, 1.0);
    if (held == nullptr || isSecond(data, h, held->part))
      data.fieldsOnPart[h].forgetHand();
    else
      pullByFields(*held, data.fieldsOnPart[h], share, now, parameters, data, out);
  }
}

void pullByMagnets(int hands, const TickParameters& parameters, Data& data, TickOutput& out) {
  data.held.forgetMagnets();
  const MagneticBodies bodies = magneticBodies(data);
  for (std::size_t h = 0; h < static_cast<std::size_t>(hands); ++h) {
    HeldMagnets& magnets = data.heldMagnets[h];
    const SimulatedPart* const held = pullable(data, h);
    const bool acts = held != nullptr && data.partContact != nullptr &&
                      data.partContact->collides(held->part) && !isSecond(data, h, held->part);
    if (!acts) {
      magnets.forget();
      continue;
    }
    const HeldMagnets::Settings settings{parameters.dt, fadeStep(parameters), shareHere(data, held->part)};
    for (const MagnetPull& pull :
         magnets.find(data.world, held->part, {bodies.data(), bodies.size()}, settings, out.flags)) {
      attract(bodies, held->part, pull.force, pull.onHeld, data);
      attract(bodies, pull.magnet, -pull.force, pull.onMagnet, data);
    }
  }
}

void feelSurfacesThroughParts(int hands, Data& data, TickOutput& out) {
  for (std::size_t h = 0; h < static_cast<std::size_t>(hands); ++h) {
    data.throughPart[h] = Wrench{};
    const SimulatedPart* const held = data.held.heldPart(static_cast<int>(h));
    const bool touches = held != nullptr && held->moved.control == nullptr && data.partContact != nullptr &&
                         data.hands[h].valid() && (h == 0 || !held->grips[0].holds);
    if (touches)
      feelSurfacesUnder(*held, h, data, out);
    else
      data.heldSurfaces[h] = {};
  }
}

}  // namespace tandem::haptics
