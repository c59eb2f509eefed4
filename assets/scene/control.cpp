#include "assets/scene/control.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include <glm/geometric.hpp>

#include "assets/scene/describe.h"
#include "assets/scene/scene.h"

namespace tandem::assets {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// `angle` plus whole turns, within half a turn of `middle`.
double wrapped(double angle, double middle) { return middle + std::remainder(angle - middle, kTurn); }

Pose alongAxis(const Control& control, double value) {
  if (turns(control)) return {glm::dvec3(0.0), fromRotationVector({value, 0.0, 0.0})};
  return {glm::dvec3(value, 0.0, 0.0), glm::dquat(1.0, 0.0, 0.0, 0.0)};
}

}  // namespace

const char* toString(ControlKind kind) {
  const auto index = static_cast<std::size_t>(kind);
  return index < std::size(kControlNames) ? kControlNames[index] : "unknown";
}

Pose poseAt(const Control& control, double value) {
  return control.worldFromAxis * alongAxis(control, value) * control.axisFromPart;
}

double controlValue(const Control& control, const Pose& worldFromPart) {
  const Pose moved = inverse(control.worldFromAxis) * worldFromPart * inverse(control.axisFromPart);
  if (!turns(control)) return moved.position.x;
  // The twist of the swing-twist decomposition: the rotation about the axis that is nearest to this one.
  const double angle = 2.0 * std::atan2(moved.orientation.x, moved.orientation.w);
  return wrapped(angle, 0.5 * (control.min + control.max));
}

double admissible(const Control& control, double value) {
  if (control.endless) return wrapped(value, 0.0);
  return std::clamp(value, control.min, control.max);
}

Twist twistAt(const Control& control, const Pose& worldFromPart, double rate) {
  const glm::dvec3 along = axisOf(control) * rate;
  if (!turns(control)) return {along, glm::dvec3(0.0)};
  return {glm::cross(along, worldFromPart.position - control.worldFromAxis.position), along};
}

glm::dvec3 axisOf(const Control& control) { return transformVector(control.worldFromAxis, {1.0, 0.0, 0.0}); }

const Control* controlOf(const Scene& scene, PartId part) {
  for (const Control& control : scene.controls)
    if (control.part == part) return &control;
  return nullptr;
}

bool roleMaySet(const Scene& scene, PartId part, unsigned role) {
  const Control* control = controlOf(scene, part);
  return control == nullptr || (role < 32 && (control->roles >> role & 1u) != 0);
}

}  // namespace tandem::assets
