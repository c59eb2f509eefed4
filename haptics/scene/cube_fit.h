#pragma once

// Affine model of the signed distance to a mesh over one cube, with a proven, not sampled, bound of its
// error.
//
// 1. Works on the few triangles that can be nearest to a point of the cube; the caller keeps that list.
// 2. For construction of models, not for ticks. Immutable and safe in every thread.
//
// The bound. Let g be a unit vector and z(x) = g . (x - c) the height over the cube's centre c. The distance
// d to the surface lies in z - high .. z - low:
// (a) low: if every line along g through the cube crosses the surface at heights of at least `low`, then
//     d(x) <= z(x) - low for all x above. All lines cross it if one line crosses it an odd number of times
//     and neither a triangle nor an open edge of the surface passes the floor or roof or leaves the sides of
//     the column under the cube, because intersection numbers mod 2 then do not change from line to line.
//     A single triangle also bounds low: its distance is convex, so d - z is largest in a corner of the cube.
// (b) high: for each triangle t, any point y and m = grad d_t(y), d_t(x) >= d_t(y) + m . (x - y), because d_t
//     is convex; and d_t(x) >= z(x) - max z(t). The least value of an affine function over the cube is known
//     exactly, and a few iterations of Frank & Wolfe search for y.

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "haptics/geometry/mesh_sides.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

struct FieldCube {
  glm::dvec3 centre{0.0, 0.0, 0.0};  // m, part frame
  double half = 0.0;                 // m, half its side
  double radius() const { return 1.7320508075688773 * half; }
};

/// distance(x) is within `error` of dot(gradient, x - centre) + value for all x in the cube.
struct CubeModel {
  glm::dvec3 gradient{0.0, 0.0, 0.0};
  double value = 0.0;  // m
  double error = 1e300;
};

class CubeFit {
 public:
  /// Both must outlive it.
  CubeFit(const TriangleBvh& tree, const MeshSides& sides) : tree_(tree), sides_(sides) {}

  /// Fits the cube. `near` holds every triangle within nearest.distance + 2 radii of the cube's centre;
  /// `nearest` is the point nearest to the centre, which lies on `side` (1 or -1; irrelevant where the
  /// surface passes the cube). Stops at an error of `enough`, and gives up as soon as an error of `limit` is
  /// out of reach. False if it found nothing better than `model`.
  bool fit(const FieldCube& cube, std::span<const std::uint32_t> near, const MeshPoint& nearest, double side,
           double enough, double limit, CubeModel& model) const;

 private:
  /// Whether the sheet of surface through the cube has outside above and inside below.
  bool parts(const FieldCube& cube, const MeshPoint& nearest, const CubeModel& model) const;

  const TriangleBvh& tree_;
  const MeshSides& sides_;
};

}  // namespace tandem::haptics
