// Construction of a TriangleBvh and its refit; the queries are in triangle_bvh.cpp.

#include <algorithm>
#include <array>
#include <barrier>
#include <thread>
#include <utility>

#include <glm/common.hpp>

#include "assets/base/assert.h"
#include "haptics/base/in_parallel.h"
#include "haptics/geometry/bvh_build.h"
#include "haptics/geometry/leaf_slab.h"
#include "haptics/geometry/outward.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {
namespace {

constexpr std::size_t kThreadsPay = 16'384;  // triangles from which a second thread pays
constexpr std::size_t kSlabBlock = 4096;     // nodes
constexpr int kMaxWorkers = 64;

int workersFor(std::size_t triangles, int threads) {
  if (triangles <= kThreadsPay) return 1;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return std::min(threads > 0 ? threads : cores, kMaxWorkers);
}

void grow(assets::Bounds& box, const assets::Bounds& other) {
  box.min = glm::min(box.min, other.min);
  box.max = glm::max(box.max, other.max);
}

/// Writes the least and greatest lanes of corners into a child's box, `outwards` by one float.
void setBox(const Vec4& low, const Vec4& high, bool outwards, TriangleBvh::Node& node, int k) {
  alignas(16) float least[4], negated[4];
  leastLanes(low).store(least);
  leastLanes(Vec4{} - high).store(negated);
  for (int axis = 0; axis < 3; ++axis) {
    node.low[axis][k] = outwards ? below(least[axis]) : least[axis];
    node.high[axis][k] = outwards ? -below(negated[axis]) : -negated[axis];
  }
}

FloatBox boxOf(const TriangleBvh::Node& node, int k) {
  return {{node.low[0][k], node.low[1][k], node.low[2][k]},
          {node.high[0][k], node.high[1][k], node.high[2][k]}};
}

}  // namespace

TriangleBvh::TriangleBvh(const assets::Mesh& mesh, int threads) : mesh_(&mesh) {
  const std::size_t count = mesh.triangles.size();
  ASSERT(count <= kLeafFirstMask);
  if (count == 0) return;
  const int workers = workersFor(count, threads);
  std::array<assets::Bounds, kMaxWorkers> bounds;
  inParallel(mesh.positions.size(), workers, [&](std::size_t begin, std::size_t end, int worker) {
    bounds[static_cast<std::size_t>(worker)] = boundsOf(begin, end);
  });
  setBounds(bounds);
  BuiltTree built = buildTree(mesh, centre_, workers);
  nodes_ = std::move(built.nodes);
  nodeCount_ = built.nodeCount;
  order_ = std::move(built.order);

  ASSERT(nodeCount_ > 0 && order_.size() == count);
  ASSERT(depth() <= kMaxDepth);
  fit(workers, false);
}

void TriangleBvh::refit(int threads) {
  ASSERT(mesh_->triangles.size() == order_.size());
  if (!empty()) fit(workersFor(order_.size(), threads), true);
}

void TriangleBvh::fit(int workers, bool haveMoved) {
  std::barrier ready(workers);
  // The blocks do not depend on the number of threads, so the slabs do not either.
  const std::size_t blocks = (nodeCount_ + kSlabBlock - 1) / kSlabBlock;
  onThreads(workers, [&](int worker) {
    const auto w = static_cast<std::size_t>(worker), n = static_cast<std::size_t>(workers);
    fitLeaves(nodeCount_ * w / n, nodeCount_ * (w + 1) / n, haveMoved);
    ready.arrive_and_wait();
    if (haveMoved) {
      // Two serial steps run at the same time.
      if (worker == 0) fitInner();
      if (worker == workers - 1) {
        const assets::Bounds all[1] = {boundsOf(0, mesh_->positions.size())};
        setBounds(all);
      }
      ready.arrive_and_wait();
    }
    for (std::size_t i = blocks * w / n; i < blocks * (w + 1) / n; ++i) {
      fitInnerSlabs(i * kSlabBlock, std::min(nodeCount_, (i + 1) * kSlabBlock));
    }
  });
}

void TriangleBvh::fitLeaves(std::size_t begin, std::size_t end, bool haveMoved) {
  ASSERT(begin <= end && end <= nodeCount_);
  for (std::size_t i = begin; i < end; ++i) {
    Node& node = nodes_[i];
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t child = node.child[k];
      node.slab[k] = 0;
      if (child == kEmptyChild || (child & kLeafBit) == 0) continue;
      const std::uint32_t count = leafCount(child);
      const Triangles4 triangles = gather4(child & kLeafFirstMask, count, centre_);
      if (haveMoved) {
        // The corners were rounded to the nearest float.
        setBox(min(triangles.a, min(triangles.b, triangles.c)),
               max(triangles.a, max(triangles.b, triangles.c)), true, node, k);
      }
      node.slab[k] = slabOfTriangles(triangles, count, boxOf(node, k));
    }
  }
}

assets::Bounds TriangleBvh::boundsOf(std::size_t begin, std::size_t end) const {
  // Two independent chains of minima hide each other's latency.
  std::array<assets::Bounds, 2> own;
  for (std::size_t i = begin; i < end; ++i) {
    const glm::dvec3& p = mesh_->positions[i];
    own[i & 1].min = glm::min(own[i & 1].min, p);
    own[i & 1].max = glm::max(own[i & 1].max, p);
  }
  grow(own[0], own[1]);
  return own[0];
}

void TriangleBvh::fitInner() {
  // Children stand after their parents.
  for (std::size_t i = nodeCount_; i-- > 0;) {
    Node& node = nodes_[i];
    for (int k = 0; k < 4; ++k) {
      if ((node.child[k] & kLeafBit) != 0) continue;
      const Node& inner = nodes_[node.child[k]];
      setBox(inner.lows(), inner.highs(), false, node, k);
    }
  }
}

void TriangleBvh::setBounds(std::span<const assets::Bounds> shares) {
  bounds_ = {};
  for (const assets::Bounds& own : shares) grow(bounds_, own);
  if (nodeCount_ == 0) centre_ = 0.5 * (bounds_.min + bounds_.max);  // a refitted tree keeps its centre
  const glm::dvec3 furthest = glm::max(glm::abs(bounds_.max - centre_), glm::abs(bounds_.min - centre_));
  extent_ = roundUp(std::max({furthest.x, furthest.y, furthest.z}));
}

void TriangleBvh::fitInnerSlabs(std::size_t begin, std::size_t end) {
  for (std::size_t i = end; i-- > begin;) {
    Node& node = nodes_[i];
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t child = node.child[k];
      if ((child & kLeafBit) != 0 || child >= end) continue;
      const Node& inner = nodes_[child];
      node.slab[k] = slabOfNode(inner.lows(), inner.highs(), inner.slab, extent_, boxOf(node, k));
    }
  }
}

}  // namespace tandem::haptics
