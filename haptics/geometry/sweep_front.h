#pragma once

// A sweep that remembers the last one: most sweeps of a tick begin where others began, and go through the
// same nodes only to find once more that nothing below them is near.
//
// 1. Answers are those of TriangleBvh::sweepBall(), to the bit.
// 2. The front is the set of the children at which the last walks stopped, each with a direction that proves
//    its distance: for a child below which every point y has away . (y - place) <= -distance, the distance of
//    a point x is at least distance + away . (x - place). A sweep looks again only below the children whose
//    proofs no longer suffice.
// 3. Fixed capacity, no allocation. The tree must outlive the front and must not be refitted under it.

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

#include "haptics/base/simd4.h"
#include "haptics/geometry/swept_boxes.h"
#include "haptics/geometry/triangle_bvh.h"
#include "haptics/geometry/triangle_sweep.h"

namespace tandem::haptics {

class SweepFront {
 public:
  /// Mesh frame, as TriangleBvh::sweepBall().
  bool sweepBall(const TriangleBvh& tree, const glm::dvec3& from, const glm::dvec3& motion, double radius,
                 double tolerance, MeshBallHit& hit, const Sections* cut = nullptr);
  /// The tree has changed or gone.
  void forget() { tree_ = nullptr; }
  /// For tests: every proof claims `by` m more than is true.
  void exaggerate(float by) { exaggeration_ = by; }

 private:
  static constexpr int kMaxBranches = 160, kMaxPacks = 80;

  using Proof = SweptBall::Proof;  // relative to the place
  /// A node some of whose children the front has not opened.
  struct Branch {
    Proof proof;
    std::uint32_t node = 0;
    int closed = 0;  // bit i: child i is not opened
  };
  /// The triangles of a leaf, relative to the place.
  struct Pack {
    Proof proof;
    Triangles4 corners;
    std::uint32_t leaf = 0;
  };
  struct Sweep;

  void begin(const TriangleBvh& tree, const glm::dvec3& place);
  bool run(Sweep& sweep);
  void testPack(Sweep& sweep, Pack& pack);
  bool addNode(std::uint32_t node);
  bool addLeaf(Sweep& sweep, std::uint32_t leaf);

  const TriangleBvh* tree_ = nullptr;
  glm::dvec3 place_{0.0, 0.0, 0.0};
  int branchCount_ = 0, packCount_ = 0;
  int resting_ = 0;  // sweeps that leave the front alone after one that it had no room for
  float exaggeration_ = 0.0f;
  std::array<Branch, kMaxBranches> branches_;
  std::array<Pack, kMaxPacks> packs_;
};

}  // namespace tandem::haptics
