#include "haptics/geometry/mesh_distance.h"

#include <cmath>

#include "assets/base/assert.h"
#include "haptics/geometry/bvh_pairs.h"
#include "haptics/geometry/triangle_pair.h"

namespace tandem::haptics {
namespace {

/// The branch-and-bound search, in A's frame.
class Search {
 public:
  Search(const TriangleBvh& a, const TriangleBvh& b, const Pose& aFromB, double reach)
      : a_(a), b_(b), rotation_(glm::mat3_cast(aFromB.orientation)), shift_(aFromB.position), reach_(reach) {
    const auto farthest = [](const assets::Bounds& box) {
      return glm::length(glm::max(glm::abs(box.min), glm::abs(box.max)));
    };
    rounding_ = 0x1p-48 * (farthest(a.bounds()) + farthest(b.bounds()) + glm::length(shift_));
  }

  const double& reach() const { return reach_; }
  bool found() const { return found_; }
  const MeshGap& gap() const { return gap_; }

  void operator()(std::uint32_t firstA, std::uint32_t countA, std::uint32_t firstB, std::uint32_t countB) {
    Facet others[TriangleBvh::kMaxLeaf];
    for (std::uint32_t j = 0; j < countB; ++j) {
      const Triangle t = b_.triangle(b_.leafTriangle(firstB + j));
      others[j] = facetOf({shift_ + rotation_ * t.a, shift_ + rotation_ * t.b, shift_ + rotation_ * t.c});
    }
    for (std::uint32_t i = 0; i < countA; ++i) {
      const Facet facet = facetOf(a_.triangle(a_.leafTriangle(firstA + i)));
      for (std::uint32_t j = 0; j < countB && reach_ >= 0.0; ++j) {
        if (furtherThan(reach_ + rounding_, facet, others[j])) continue;
        consider(a_.leafTriangle(firstA + i), facet.t, b_.leafTriangle(firstB + j), others[j].t);
      }
    }
  }

 private:
  void consider(std::uint32_t indexA, const Triangle& a, std::uint32_t indexB, const Triangle& b) {
    const TrianglePairGap pair = nearestPoints(a, b);
    const double distance = std::sqrt(pair.square);
    if (distance > reach_) return;
    // A tie goes to the lower indices, so the result does not depend on the shape of the trees.
    const bool lower = indexA < gap_.triangleA || (indexA == gap_.triangleA && indexB < gap_.triangleB);
    if (found_ && distance == gap_.distance && !lower) return;
    found_ = true;
    gap_ = {distance, pair.onA, pair.onB, indexA, indexB};
    reach_ = distance > 0.0 ? distance : -HUGE_VAL;
  }

  const TriangleBvh &a_, &b_;
  glm::dmat3 rotation_;
  glm::dvec3 shift_;
  double reach_;     // m; negative once the surfaces are known to meet
  double rounding_;  // m, of coordinates in A's frame
  bool found_ = false;
  MeshGap gap_;
};

}  // namespace

bool nearestPoints(const PlacedMesh& a, const PlacedMesh& b, double reach, MeshGap& gap) {
  ASSERT(a.tree != nullptr && b.tree != nullptr);
  const Pose aFromB = inverse(a.worldFromMesh) * b.worldFromMesh;
  Search search(*a.tree, *b.tree, aFromB, reach);
  BvhPairs(*a.tree, *b.tree, aFromB).forEach(search.reach(), search);
  if (!search.found()) return false;
  gap = search.gap();
  ASSERT(!(gap.distance < 0.0) && gap.triangleA != kNoTriangle && gap.triangleB != kNoTriangle);
  gap.onA = transformPoint(a.worldFromMesh, gap.onA);
  gap.onB = transformPoint(a.worldFromMesh, gap.onB);
  return true;
}

}  // namespace tandem::haptics
