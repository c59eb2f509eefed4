#pragma once

// The last part of a swept test: four triangles that a ball may meet are excluded in float where that is
// certain, the others are tested in double. What is met first does not depend on the order of the triangles.

#include <algorithm>
#include <cstdint>

#include <glm/geometric.hpp>

#include "haptics/base/section.h"
#include "haptics/geometry/outward.h"
#include "haptics/geometry/triangle_bvh.h"
#include "haptics/geometry/triangle_filter.h"
#include "haptics/geometry/triangle_math.h"

namespace tandem::haptics {

class TriangleSweep {
 public:
  /// `rounding`: m, of differences of coordinates there. Looks for hits up to hit.t.
  /// Only what `cut` leaves of the triangles counts, if not null.
  TriangleSweep(const TriangleBvh& tree, const glm::dvec3& from, const glm::dvec3& motion, double radius,
                double tolerance, double rounding, const Sections* cut, MeshBallHit& hit);

  /// Tests the first `count` of four triangles; corners are relative to the start of the motion.
  void test(const Triangles4& corners, const std::uint32_t* triangles, std::uint32_t count) {
    Vec4 away;
    Float4 distance;
    test(corners, triangles, count, away, distance);
  }
  /// The same; tells how far the triangles certainly are from the start, m, and in which unit directions.
  void test(const Triangles4& corners, const std::uint32_t* triangles, std::uint32_t count, Vec4& away,
            Float4& distance);

  bool found() const { return found_; }
  /// The share of the motion up to which a hit still counts.
  float latest() const { return latest_; }
  const Vec4& motion() const { return motion4_; }
  /// m: a triangle that stays farther away than this from the centre is not met.
  Float4 reach() const { return reach_; }
  std::uint64_t tested() const { return tested_; }

 private:
  void testOne(std::uint32_t index, const glm::dvec3& away);

  const TriangleBvh& tree_;
  const glm::dvec3 from_, way_;
  const double radius_, tolerance_, closest_;
  const Vec4 motion4_;
  const Float4 reach_;
  const Sections* const cut_;
  MeshBallHit& hit_;
  float latest_;
  bool found_ = false;
  std::uint64_t tested_ = 0;
};

}  // namespace tandem::haptics
