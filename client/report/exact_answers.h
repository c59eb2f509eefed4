#pragma once

// The position of an ideal god object in closed form, with which every measured force is compared. For
// polygons see assets/generate/profile_god_object.h. Lengths in m, part frame.

#include <glm/vec3.hpp>

namespace tandem::client::report {

/// The position of a ball's centre nearest to `goal` outside a sphere around the origin; `radius` is the sum
/// of both radii. For a goal at the centre of the sphere, the one on +z.
glm::dvec3 outsideSphere(const glm::dvec3& goal, double radius);

/// The nearest point to `goal` with z >= height.
glm::dvec3 abovePlane(const glm::dvec3& goal, double height);

/// The nearest point to `goal` between the walls of a groove along y with its apex at the origin, each wall
/// at `halfAngle` rad from +z: |x| cos(halfAngle) <= z sin(halfAngle).
glm::dvec3 insideGroove(const glm::dvec3& goal, double halfAngle);

}  // namespace tandem::client::report
