#pragma once

// The bounds of what shading does to the force.
//
// 1. The force is no larger than that of the facets' contact and of the trusted height of the surface over
//    them.
// 2. It changes in a tick by no more than a spring over the travel, and a little (kUnfelt in the source).
//    Where the normals are wholly a surface's, whose curvature turns the force faster, it may by a multiple
//    of that; and there, or where the tool goes on to another surface, by as much as the facets' own force.
// 3. Neither acts on a smooth surface, so that its force stays the gradient of a potential.

#include <cstdint>

#include <glm/vec3.hpp>

#include "assets/base/ids.h"

namespace tandem::haptics {

/// The touches with shaded parts in one tick.
struct ShadedTouches {
  bool any = false;
  bool other = false;      // effects beside shading act, whose force may jump
  double relief = 0.0;     // N, of the surfaces' heights over their facets
  double stiffness = 0.0;  // N/m, the stiffest
  double travel = 0.0;     // m, of the surfaces
  double trust = 1.0;      // the least PatchPoint::trust
  double steepness = 1.0;  // the greatest PatchPoint::steepness
  PartId part = kNoPart;   // of the first touch, and its ShadedMesh::region
  std::uint32_t region = 0;
};

/// What shading gave in the last tick.
struct ShadingMemory {
  glm::dvec3 felt{0.0, 0.0, 0.0};    // N, with shading
  glm::dvec3 plain{0.0, 0.0, 0.0};   // N, of the facets
  glm::dvec3 device{0.0, 0.0, 0.0};  // m, world
  PartId part = kNoPart;             // ShadedTouches::part, region
  std::uint32_t region = 0;
  bool valid = false;
};

/// The force nearest to `wanted` within the bounds, N; `plain` is that of the facets, `device` m, world. Does
/// nothing where other effects act.
glm::dvec3 holdShading(const ShadedTouches& touches, const glm::dvec3& device, const glm::dvec3& plain,
                       const glm::dvec3& wanted, ShadingMemory& memory);

}  // namespace tandem::haptics
