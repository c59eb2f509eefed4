#pragma once

// Controls made in code, with known profiles, for tests of what they feel like.

#include <glm/geometric.hpp>

#include "assets/scene/control.h"
#include "tests/support/shapes.h"

namespace tandem::test {

/// A control whose axis goes through `origin` along one of the world's axes, for a part that now stands at
/// `worldFromPart` with the value `initial`.
inline assets::Control controlAlong(assets::ControlKind kind, const glm::dvec3& axis,
                                    const glm::dvec3& origin, const Pose& worldFromPart, double min,
                                    double max, double initial = 0.0) {
  assets::Control c;
  c.name = "control";
  c.part = 0;
  c.kind = kind;
  const glm::dvec3 x(1.0, 0.0, 0.0);
  const double cosine = glm::dot(x, axis);
  c.worldFromAxis.position = origin;
  c.worldFromAxis.orientation = cosine < -0.999
                                    ? glm::dquat(0.0, 0.0, 0.0, 1.0)
                                    : glm::normalize(glm::dquat(1.0 + cosine, glm::cross(x, axis)));
  c.min = min;
  c.max = max;
  c.initial = initial;
  c.inertia = 0.02;
  const Pose worldFromAxisNow = assets::poseAt(c, initial);
  c.axisFromPart = inverse(worldFromAxisNow) * worldFromPart;
  return c;
}

/// A push button 20 x 20 x 10 (times `s` mm) whose top is z = 0, pushed along -z by 2 s mm; its forces grow
/// with its lengths, so that the dynamics are the same at every scale.
inline SceneBuilder buttonScene(double s) {
  SceneBuilder b;
  const Pose pose{glm::dvec3(0.0, 0.0, -5e-3 * s), glm::dquat(1.0, 0.0, 0.0, 0.0)};
  b.addPart(boxMesh(glm::dvec3(20e-3, 20e-3, 10e-3) * s), pose, 0.02);
  assets::Control c =
      controlAlong(assets::ControlKind::button, {0.0, 0.0, -1.0}, glm::dvec3(0.0), pose, 0.0, 2e-3 * s);
  c.springStiffness = 300.0;
  c.springRest = -1e-3 * s;
  c.damping = 2.0;
  c.click = {1e-3 * s, 0.8 * s, 0.3e-3 * s};
  b.scene.controls.push_back(c);
  return b;
}

/// An arm of 100 x 10 x 10 (times s mm) that turns about z at its left end, with 12 detents of 0.02 s N·m ...
/// a dial as a tool turns it by pushing the arm's side.
inline SceneBuilder dialScene(double s) {
  SceneBuilder b;
  const Pose pose{glm::dvec3(50e-3 * s, 0.0, 0.0), glm::dquat(1.0, 0.0, 0.0, 0.0)};
  b.addPart(boxMesh(glm::dvec3(100e-3, 10e-3, 10e-3) * s), pose, 0.05);
  assets::Control c =
      controlAlong(assets::ControlKind::dial, {0.0, 0.0, 1.0}, glm::dvec3(0.0), pose, -kPi, kPi);
  c.endless = true;
  c.inertia = 5e-5 * s * s;
  c.damping = 1e-3 * s * s;
  for (int i = 0; i < 12; ++i) c.detents.places.push_back(-kPi + i * kPi / 6.0);
  c.detents.force = 0.02 * s * s;
  b.scene.controls.push_back(c);
  return b;
}

}  // namespace tandem::test
