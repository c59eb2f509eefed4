#include "haptics/geometry/sweep_front.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/geometry/bvh_fit.h"
#include "haptics/geometry/outward.h"
#include "haptics/geometry/query_work.h"

namespace tandem::haptics {
namespace {

constexpr int kRest = 16;  // sweeps for which the tree answers after the front had no room
// With more than these to look through, the front begins anew.
constexpr int kManyBranches = 64, kManyPacks = 32;

Vec4 inEveryLane(const glm::dvec3& v) {
  return {Float4(static_cast<float>(v.x)), Float4(static_cast<float>(v.y)), Float4(static_cast<float>(v.z))};
}

}  // namespace

/// One query of the front.
struct SweepFront::Sweep {
  const SweptBall& ball;
  TriangleSweep& triangles;
  const glm::dvec3 from;
  const Vec4 by;           // m, from the place to the start
  const Float4 rounding;   // m, of distances evaluated at the start
  const Float4 allowance;  // m, of fresh distances of nodes
  std::uint64_t nodes = 0;

  /// The lanes that may be met, as far as the proofs tell.
  int mayMeet(const Proof& proof) const {
    const Float4 nearing = min(dot(proof.away, triangles.motion()) * Float4(triangles.latest()), Float4());
    const Float4 least = proof.distance + dot(proof.away, by) + nearing - rounding;
    return 15 & ~lessMask(triangles.reach(), least);
  }
  /// A proof at the start as one relative to the place.
  Proof kept(const Proof& proof, Float4 allowed) const {
    return {proof.away, proof.distance - dot(proof.away, by) - allowed};
  }
};

bool SweepFront::sweepBall(const TriangleBvh& tree, const glm::dvec3& from, const glm::dvec3& motion,
                           double radius, double tolerance, MeshBallHit& hit, const Sections* cut) {
  if (tree.empty()) return false;
  // What a point or a ball passes on a long path is better excluded by the boxes beside that path.
  if (glm::length(motion) > radius) return tree.sweepBall(from, motion, radius, tolerance, hit, cut);
  if (resting_ > 0) {
    --resting_;
    return tree.sweepBall(from, motion, radius, tolerance, hit, cut);
  }
  if (tree_ != &tree || branchCount_ > kManyBranches || packCount_ > kManyPacks) {
    begin(tree, from);
  }
  const glm::dvec3 origin = from - tree.centre(), offset = from - place_;
  const double largest = tree.largest() + radius + glm::length(origin) + glm::length(motion);
  const double away = glm::length(offset);
  MeshBallHit found = hit;
  const SweptBall ball(origin, motion, radius + tolerance, largest);
  // Corners were rounded relative to the place.
  TriangleSweep triangles(tree, from, motion, radius, tolerance,
                          tree.coordinateRounding(from) + 0x1p-21 * away, cut, found);
  Sweep sweep{ball,
              triangles,
              from,
              inEveryLane(offset),
              Float4(roundUp(0x1p-20 * (away + glm::length(motion)))),
              Float4(roundUp(0x1p-18 * (largest + away)) - exaggeration_)};
  const bool whole = run(sweep);
  ++queryWork.queries;
  queryWork.nodes += sweep.nodes;
  queryWork.triangles += triangles.tested();
  if (!whole) {
    forget();
    resting_ = kRest;
    return tree.sweepBall(from, motion, radius, tolerance, hit, cut);
  }
  if (triangles.found()) hit = found;
  return triangles.found();
}

void SweepFront::begin(const TriangleBvh& tree, const glm::dvec3& place) {
  tree_ = &tree;
  place_ = place;
  branchCount_ = packCount_ = 0;
  addNode(0);
}

/// False if the front has no room for what the sweep may meet.
bool SweepFront::run(Sweep& sweep) {
  // Known triangles first: an early hit spares most of the front.
  for (int i = 0, known = packCount_; i < known; ++i) testPack(sweep, packs_[static_cast<std::size_t>(i)]);
  for (int i = 0; i < branchCount_; ++i) {
    Branch& branch = branches_[static_cast<std::size_t>(i)];
    int mask = sweep.mayMeet(branch.proof) & branch.closed;
    if (mask == 0) continue;
    ++sweep.nodes;
    const TriangleBvh::Node& node = tree_->nodes()[branch.node];
    Proof fresh;
    mask &= sweep.ball.enter(node, sweep.triangles.latest(), fresh);
    branch.proof = sweep.kept(fresh, sweep.allowance);
    branch.closed &= ~mask;
    const int closed = branch.closed;
    for (std::size_t k = 0; k < 4; ++k) {
      if ((mask >> k & 1) == 0) continue;
      const std::uint32_t child = node.child[k];
      const bool leaf = (child & TriangleBvh::kLeafBit) != 0;
      if (!(leaf ? addLeaf(sweep, child) : addNode(child))) return false;
    }
    if (closed != 0) continue;
    branches_[static_cast<std::size_t>(i)] = branches_[static_cast<std::size_t>(--branchCount_)];
    --i;
  }
  return true;
}

bool SweepFront::addNode(std::uint32_t index) {
  if (branchCount_ == kMaxBranches) return false;
  const TriangleBvh::Node& node = tree_->nodes()[index];
  Branch& branch = branches_[static_cast<std::size_t>(branchCount_++)];
  branch.node = index;
  branch.closed = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    if (node.child[k] != TriangleBvh::kEmptyChild) branch.closed |= 1 << k;
  }
  branch.proof = {Vec4{}, Float4(-1e30f)};  // proves nothing
  return true;
}

bool SweepFront::addLeaf(Sweep& sweep, std::uint32_t leaf) {
  if (packCount_ == kMaxPacks) return false;
  Pack& pack = packs_[static_cast<std::size_t>(packCount_++)];
  pack.leaf = leaf;
  pack.corners = leafTriangles(tree_->mesh(), tree_->leafTriangles(leaf & TriangleBvh::kLeafFirstMask),
                               TriangleBvh::leafCount(leaf), place_);
  pack.proof = {Vec4{}, Float4(-1e30f)};
  testPack(sweep, pack);
  return true;
}

void SweepFront::testPack(Sweep& sweep, Pack& pack) {
  if (sweep.mayMeet(pack.proof) == 0) return;
  const Triangles4 corners{pack.corners.a - sweep.by, pack.corners.b - sweep.by, pack.corners.c - sweep.by};
  const std::uint32_t* const triangles = tree_->leafTriangles(pack.leaf & TriangleBvh::kLeafFirstMask);
  Proof fresh;
  sweep.triangles.test(corners, triangles, TriangleBvh::leafCount(pack.leaf), fresh.away, fresh.distance);
  pack.proof = sweep.kept(fresh, sweep.rounding);
}

}  // namespace tandem::haptics
