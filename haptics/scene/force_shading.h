#pragma once

// Force shading: faceted meshes of curved surfaces feel curved.
//
// Morgenbesser & Srinivasan 1996 and Ruspini, Kolarov & Khatib 1997 turn the force to an interpolated normal.
// That force is not the gradient of a potential, so a closed path can gain energy, and the height stays that
// of the facets. Here each triangle becomes a curved patch (Phong tessellation, Boubekeur & Alexa 2008, which
// with weight 1/2 follows quadratic surfaces exactly), the device is projected onto it along the interpolated
// normals (Phong projection, Kobbelt et al. 1999; Panozzo et al. 2013), and the force is the gradient of a
// potential of the resulting depth.
//
// 1. Depth is continuous where patches meet across smooth edges, because they share corner normals.
// 2. Corner normals do not mix across an edge above the crease angle, between materials of which one is not
//    smooth, or at open and non-manifold edges.
//

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// Data that force shading adds to a mesh of T triangles. Immutable.
struct ShadedMesh {
  std::vector<std::array<glm::vec3, 3>> normals;           // T, unit, of the corners
  std::vector<std::array<std::uint32_t, 3>> smoothAcross;  // T, neighbour across smooth edge e, or kNone
  double relief = 0.0;                                     // m, no patch is farther from its triangle
};

/// Corner normals by Max 1999, "Weights for computing vertex normals from facet normals": exact for vertices
/// on a sphere. `creaseOf`: one angle a material, rad; 0 = flat facets. O(T).
ShadedMesh shadeMesh(const assets::Mesh& mesh, std::span<const double> creaseOf);

/// Position of a point relative to the curved patches of a mesh, part frame.
struct PatchPoint {
  std::uint32_t triangle = assets::kNone;
  double u = 0.0, v = 0.0;                  // barycentric coordinates of corners 1 and 2
  glm::dvec3 point{0.0, 0.0, 0.0};          // m, on the patch
  glm::dvec3 normal{0.0, 0.0, 0.0};         // unit, on the side of the query point
  double depth = 0.0;                       // m, point - depth * normal is the query point
  glm::dvec3 depthGradient{0.0, 0.0, 0.0};  // of depth, by the query point
  glm::dvec3 uGradient{0.0, 0.0, 0.0}, vGradient{0.0, 0.0, 0.0};  // 1/m
  glm::dvec3 pointU{0.0, 0.0, 0.0}, pointV{0.0, 0.0, 0.0};        // m, derivatives of `point`
};

/// Projects p onto the patch of `triangle`, or onto a nearby one joined by smooth edges. `start` is the
/// initial point on the triangle; `side` is 1 if p is on the triangle's front side, else -1. `shaded` may be
/// null, for flat facets. False where the patches fold: deeper than their radius of curvature, or far beyond
/// a crease. Work is bounded.
bool projectOntoPatch(const assets::Mesh& mesh, const ShadedMesh* shaded, std::uint32_t triangle,
                      const glm::dvec3& start, const glm::dvec3& p, double side, PatchPoint& found);

}  // namespace tandem::haptics
