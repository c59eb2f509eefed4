#pragma once

// Force shading: faceted meshes of curved surfaces feel curved.
//
// Morgenbesser & Srinivasan 1996 and Ruspini, Kolarov & Khatib 1997 turn the force to an interpolated normal.
// That force is not the gradient of a potential, so a closed path can gain energy, and the height stays that
// of the facets. Here each triangle becomes a curved patch (curved_patch.h), the device is projected onto it
// along the interpolated normals (Phong projection, Kobbelt et al. 1999; Panozzo et al. 2013), and the force
// is the gradient of a potential of the resulting depth.
//
// 1. Depth is continuous where patches meet across smooth edges, because they share corner normals.
// 2. Corner normals do not mix across sharp edges (corner_normals.h says which are), between materials of
//    which one is not smooth, or at open and non-manifold edges.
// 3. A projection along normals that converge ends where depth times curvature is 1. `share` fades to 0
//    before, so that the facets' own force takes over; `relief` bounds by how much a patch may be deeper than
//    its facet, and is 0 where the normals follow noise instead of a surface.

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/scene/scene.h"
#include "haptics/scene/curved_patch.h"

namespace tandem::haptics {

/// How the surface bends around a corner. Curvatures are upper bounds for the triangles around it.
struct CornerBend {
  std::uint16_t convex = 0, concave = 0;  // 1/m, >= 0, of the front side; the upper half of a float
  std::uint16_t trust = 0;                // share / 65535 of the patch's height that is the surface's own
};

/// A curvature as a CornerBend holds it, never less than `value`; and back.
std::uint16_t packCurvature(double value);
double unpackCurvature(std::uint16_t packed);

/// Data that force shading adds to a mesh of T triangles. Immutable.
struct ShadedMesh {
  std::vector<CornerNormals> normals;                      // T
  std::vector<std::array<CornerBend, 3>> bends;            // T
  std::vector<std::array<std::uint32_t, 3>> smoothAcross;  // T, neighbour across smooth edge e, or kNone
  std::vector<std::uint32_t> region;  // T, the least triangle that can be reached across smooth edges
  double relief = 0.0;                // m, no patch is farther from its triangle
};

/// Whether two triangles belong to one smooth surface where they meet.
bool smoothTogether(const ShadedMesh& shaded, const assets::Mesh& mesh, std::uint32_t a, std::uint32_t b);

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
  double share = 1.0;   // of this depth in the force; the rest is the facets'
  double steepness = 1.0;  // >= 1, how much faster the force changes at most than that of a spring
  double trust = 0.0;   // 0..1 at the start: how far the normals are a surface's, not noise
  double relief = 0.0;  // m, >= 0, height of that surface over the facet at the start
};

/// Projects p onto the patch of `triangle`, or onto a nearby one joined by smooth edges. `start` is the
/// initial point on the triangle; `side` is 1 if p is on the triangle's front side, else -1. `shaded` may be
/// null, for flat facets. False where the patches fold: deeper than their radius of curvature, or far beyond
/// a crease. Work is bounded.
bool projectOntoPatch(const assets::Mesh& mesh, const ShadedMesh* shaded, std::uint32_t triangle,
                      const glm::dvec3& start, const glm::dvec3& p, double side, PatchPoint& found);

/// Largest angle between the facet of a triangle and its corner normals, rad.
double facetTurn(const assets::Mesh& mesh, const ShadedMesh& shaded, std::uint32_t triangle);

}  // namespace tandem::haptics
