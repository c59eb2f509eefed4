#pragma once

// A mesh with lids over its holes, so that it has an inside however it is turned.
//
// 1. With the lids every edge is used equally often both ways. The winding number is then whole, and every
//    ray from a point counts the same; a closed mesh has no lids.
// 2. A lid is a guess at what the file lacks. isCertain() tells where it does not matter.
// 3. Immutable and safe in every thread. For reviews, never in a tick: it allocates. The tree and its mesh
//    must outlive it.

#include <memory>

#include "haptics/geometry/triangle_bvh.h"
#include "haptics/geometry/winding_tree.h"

namespace tandem::haptics {

class MeshClosing {
 public:
  explicit MeshClosing(const TriangleBvh& tree);

  const TriangleBvh& tree() const { return tree_; }
  /// Twice the distance of the farthest vertex from the mean of all, m: a size that turning does not change.
  double size() const { return size_; }
  /// The lids, in the mesh's frame; null where the mesh is closed.
  const TriangleBvh* lids() const { return lids_.get(); }

  /// Whether p (mesh frame) is inside: the winding number of mesh and lids is not 0, so that inverted shells
  /// are solid too. An open sheet has no inside, because its lid is its own back.
  bool contains(const glm::dvec3& p) const;
  /// Share of the sphere about p that the lids cover, signed. The generalised winding number of the mesh
  /// (Jacobson, Kavan & Sorkine-Hornung 2013, "Robust inside-outside segmentation using generalized winding
  /// numbers") differs from the whole number of contains() by just this.
  double lidShare(const glm::dvec3& p) const;
  /// The same within an error, which is 0 where there are few lids: a tree bounds the cost of many.
  struct RoughShare {
    double value, error;
  };
  RoughShare roughLidShare(const glm::dvec3& p) const;
  /// Whether the lids cover less than a quarter of the sphere about p: the generalised winding number is
  /// then nearer to the whole number than to any doubt.
  bool isCertain(const glm::dvec3& p) const;
  static constexpr double kMaxLidShare = 0.25;

 private:
  int crossings(const glm::dvec3& from, const glm::dvec3& to) const;

  const TriangleBvh& tree_;
  double size_ = 0.0;
  assets::Mesh lidMesh_;
  std::unique_ptr<TriangleBvh> lids_;
  std::unique_ptr<WindingTree> lidWinding_;  // null where there are few lids
};

}  // namespace tandem::haptics
