#include "haptics/grasp/controls.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

/// Velocity of a point of the part for each unit of the control's rate: m/s for 1 m/s, or for 1 rad/s.
glm::dvec3 leverAt(const assets::Control& control, const glm::dvec3& point) {
  const glm::dvec3 axis = assets::axisOf(control);
  return assets::turns(control) ? glm::cross(axis, point - control.worldFromAxis.position) : axis;
}

void place(const MovedControl& moved, Pose& worldFromPart, Twist& twist) {
  worldFromPart = assets::poseAt(*moved.control, moved.state.value);
  twist = assets::twistAt(*moved.control, worldFromPart, moved.state.rate);
}

AxisLoad sum(const AxisLoad& a, const AxisLoad& b) {
  return {a.force + b.force, a.stiffness + b.stiffness, a.damping + b.damping};
}

}  // namespace

MovedControl takeControl(const ContactWorld& world, PartId part, RigidBody& body) {
  MovedControl moved;
  moved.control = assets::controlOf(world.scene(), part);
  if (moved.control == nullptr) return moved;
  moved.steepest = steepestResistance(*moved.control);
  moved.state.value =
      assets::admissible(*moved.control, assets::controlValue(*moved.control, world.pose(part)));
  const glm::dvec3 origin = moved.control->worldFromAxis.position, axis = assets::axisOf(*moved.control),
                   middle = transformPoint(world.pose(part), world.collider(part).centre);
  body.centreOfMass =
      transformPoint(inverse(world.pose(part)), origin + axis * glm::dot(axis, middle - origin));
  return moved;
}

AxisLoad toolLoad(const ContactWorld& world, const Proxy& proxy, const assets::Control& control,
                  const glm::dvec3& force, const TickParameters& parameters) {
  glm::dvec3 point(0.0);
  double depths = 0.0, stiffness = 0.0, damping = 0.0;
  for (const ProxyPlane& plane : proxy.planes) {
    if (plane.surface.part != control.part || !isFelt(plane)) continue;
    const assets::Material& material = world.material(plane.surface.part, plane.surface.triangle);
    point += plane.depth * plane.surface.point;
    depths += plane.depth;
    stiffness = std::max(stiffness, material.stiffness > 0.0 ? material.stiffness : parameters.stiffness);
    damping = std::max(damping, material.damping > 0.0 ? material.damping : parameters.damping);
  }
  if (!(depths > 0.0)) return {};
  const glm::dvec3 lever = leverAt(control, point / depths);
  const double scale = glm::dot(lever, lever);
  return {-glm::dot(lever, force), stiffness * scale, damping * scale};
}

void stepFree(MovedControl& moved, double dt, Pose& worldFromPart, Twist& twist) {
  stepControl(*moved.control, moved.steepest, moved.tool, dt, moved.state);
  place(moved, worldFromPart, twist);
}

Wrench stepHeld(MovedControl& moved, const Pose& partFromGrip, const DeviceSample& device,
                const CouplingGains& gains, double dt, Pose& worldFromPart, Twist& twist) {
  const assets::Control& control = *moved.control;
  const Pose worldFromGrip = worldFromPart * partFromGrip;
  const glm::dvec3 lever = leverAt(control, worldFromGrip.position);
  const glm::dvec3 spin = assets::turns(control) ? assets::axisOf(control) : glm::dvec3(0.0);
  const glm::dvec3 gap = device.worldFromDevice.position - worldFromGrip.position;
  const glm::dvec3 angle =
      rotationVector(device.worldFromDevice.orientation * glm::conjugate(worldFromGrip.orientation));
  // The coupling's force if the part stood still.
  const glm::dvec3 force = gains.stiffness * gap + gains.damping * device.twist.linear;
  const glm::dvec3 torque = gains.rotStiffness * angle + gains.rotDamping * device.twist.angular;
  const double lever2 = glm::dot(lever, lever), spin2 = glm::dot(spin, spin);
  const double damping = gains.damping * lever2 + gains.rotDamping * spin2;
  const AxisLoad hand{glm::dot(lever, force) + glm::dot(spin, torque) - damping * moved.state.rate,
                      gains.stiffness * lever2 + gains.rotStiffness * spin2, damping};
  const double before = moved.state.value;
  stepControl(control, moved.steepest, sum(hand, moved.tool), dt, moved.state);
  place(moved, worldFromPart, twist);
  // The coupling's force at the end of the step is the exact reaction to what acted on the part. At a stop
  // the part moved less than its rate says, so the displacement counts, not the rate.
  double displacement = moved.state.value - before;
  if (control.endless) displacement = std::remainder(displacement, control.max - control.min);
  const double rate = displacement / dt;
  const double drag = gains.damping + dt * gains.stiffness;
  const double rotDrag = gains.rotDamping + dt * gains.rotStiffness;
  return {drag * rate * lever - force, rotDrag * rate * spin - torque};
}

MovingPart guidedPart(const MovedControl& moved, RigidBody& body, double radius, double dt) {
  const assets::Control& control = *moved.control;
  const bool turns = assets::turns(control);
  const glm::dvec3 axis = assets::axisOf(control);
  const GuidedRate free = guidedRate(control, moved.steepest, moved.tool, dt, moved.state);
  constexpr double kNoStop = std::numeric_limits<double>::infinity();
  MovingPart part;
  part.part = control.part;
  part.step = guidedStep(axis, turns, free.rate, free.inertia, radius);
  part.body = &body;
  part.axis = {turns ? glm::dvec3(0.0) : axis,
               turns ? axis : glm::dvec3(0.0),
               control.endless ? kNoStop : moved.state.value - control.min,
               control.endless ? kNoStop : control.max - moved.state.value,
               control.friction,
               free.inertia};
  return part;
}

void endGuided(MovedControl& moved, const Displacement& displacement, double dt, Pose& worldFromPart,
               Twist& twist) {
  const glm::dvec3 axis = assets::axisOf(*moved.control);
  const bool turns = assets::turns(*moved.control);
  const double along = glm::dot(axis, turns ? displacement.angular : displacement.linear);
  const double wanted = moved.state.value + along;
  moved.state.value = assets::admissible(*moved.control, wanted);
  const bool stopped = !moved.control->endless && moved.state.value != wanted;
  moved.state.rate = stopped ? 0.0 : along / dt;
  place(moved, worldFromPart, twist);
}

bool isQuiet(const MovedControl& moved) {
  constexpr double kSlow = 1e-3;  // of the range, 1/s
  const double range = moved.control->max - moved.control->min;
  return moved.tool.stiffness == 0.0 && !moved.pushed && std::abs(moved.state.rate) <= kSlow * range;
}

Layers::Layers(const assets::Scene& scene) {
  for (const assets::Control& control : scene.controls)
    if (control.kind == assets::ControlKind::layer) layers_.push_back(&control);
}

}  // namespace tandem::haptics
