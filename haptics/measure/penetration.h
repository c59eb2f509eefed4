#pragma once

// Exact penetration depth of two parts. It judges the contact of parts, and shares with it only the triangle
// tree and the arithmetic of triangles.
//
// The depth of two solids A and B is the largest distance to B's surface of a point of A's surface inside B,
// or to A's surface of a point of B's surface inside A, whichever is larger; 0 where neither surface is
// inside the other.
// 1. Along convex edges, including their ends, the maximum is exact within 1e-7 of the smaller part's
//    diagonal. A ray from a point of a face of A inside B into A meets B's surface no sooner than the depth
//    of that point, so faces are deeper than all edges only where A is not much thicker than the depth. Faces
//    are searched where edges cross them, and everywhere within 1 % of the depth (at most 4000 pieces) once
//    anything is deeper than 5e-3 of the smaller part.
// 2. A part with an open or torn surface has no inside, but crossings count: an edge through the surface is
//    as deep as the shorter of its two ends reaches, by distance from the surface. A part whose edges do not
//    cross the surface has depth 0, however far inside it seems to be.
// 3. Overlapping shells of one part count by winding number; distances are to the nearest surface, including
//    inner walls.
// 4. Coinciding surfaces are not inside each other: two equal parts in the same place have depth 0.
// 5. For measurements: it allocates, and its time is unbounded.

#include <cstdint>
#include <memory>
#include <vector>

#include "assets/base/pose.h"
#include "haptics/measure/depth_model.h"

namespace tandem::haptics {

struct PenetrationDepth {
  double depth = 0.0;                // m
  glm::dvec3 point{0.0, 0.0, 0.0};   // world: the deepest point, where the depth is not 0
  glm::dvec3 normal{0.0, 0.0, 0.0};  // world, unit: the shortest direction out for A there
  bool ofA = true;                   // the point is one of A's surface
};

/// Measures two parts repeatedly, fastest where they move little between calls.
class PenetrationMeter {
 public:
  PenetrationMeter(std::shared_ptr<const DepthModel> a, std::shared_ptr<const DepthModel> b);
  ~PenetrationMeter();
  PenetrationMeter(PenetrationMeter&&) noexcept;
  PenetrationMeter& operator=(PenetrationMeter&&) noexcept;

  PenetrationDepth measure(const Pose& worldFromA, const Pose& worldFromB);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// One measurement with fresh state.
PenetrationDepth deepestPenetration(const DepthModel& a, const Pose& worldFromA, const DepthModel& b,
                                    const Pose& worldFromB);

}  // namespace tandem::haptics
