#pragma once

// Solids with facets of many sizes, one from each seed, and how one is pressed onto another: lumpy blobs,
// stepped blocks with bevels, turned profiles with ridges. About 20 to 40 mm large; m.

#include <random>

#include "assets/base/pose.h"
#include "assets/mesh/mesh_analysis.h"

namespace tandem::generate {

enum class Family { blobs, blocks, turned };
const char* familyName(Family family);

/// A blob out of an octahedron whose faces are cut into n x n triangles, with corners off by up to a third of
/// a triangle.
assets::TriangleSoup blobSoup(std::mt19937& random, int n);

/// Blobs of 200 to 12,800 triangles.
assets::Mesh irregularMesh(Family family, unsigned seed);

/// One part is led 2 mm into another, which lies at the origin, and then 10 mm aside while it turns: poses,
/// places and ways of each seed its own. World frame.
class PressPath {
 public:
  static constexpr double kPressSpeed = 0.02, kSlideSpeed = 0.04;          // m/s
  static constexpr double kAbove = 0.0005, kPress = 0.002, kSlide = 0.01;  // m
  static constexpr double kBlend = 0.05;  // s, over which a speed rises or falls

  explicit PressPath(unsigned seed);

  /// How the part at the origin lies.
  const glm::dquat& lying() const { return lying_; }
  /// Where the other one begins, at the height of beginAt(); before it is called, in the plane z = 0.
  const Pose& start() const { return start_; }
  /// Begins kAbove over the height at which the parts touch.
  void beginAt(double touchingHeight) { start_.position.z = touchingHeight + kAbove; }

  double duration() const;  // s
  Pose at(double time) const;

 private:
  double pressing() const;

  glm::dquat lying_{1.0, 0.0, 0.0, 0.0};
  Pose start_;
  glm::dvec3 rotation_{0.0, 0.0, 0.0};
  double angle_ = 0.0;
};

}  // namespace tandem::generate
