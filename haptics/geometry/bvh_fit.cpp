#include "haptics/geometry/bvh_fit.h"

#include <array>
#include <barrier>
#include <thread>

#include <glm/common.hpp>

#include "assets/base/assert.h"
#include "haptics/base/in_parallel.h"
#include "haptics/geometry/leaf_slab.h"
#include "haptics/geometry/outward.h"

namespace tandem::haptics {
namespace {

constexpr std::size_t kThreadsPay = 16'384;  // triangles from which a second thread pays
constexpr std::size_t kSlabBlock = 4096;     // nodes
constexpr int kMaxWorkers = 64;

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

/// Exact bounds of points [begin, end) of the mesh; none is unused (assets/mesh/mesh_analysis.h).
assets::Bounds boundsOf(const assets::Mesh& mesh, std::size_t begin, std::size_t end) {
  // Two independent chains of minima hide each other's latency.
  std::array<assets::Bounds, 2> own;
  for (std::size_t i = begin; i < end; ++i) {
    const glm::dvec3& p = mesh.positions[i];
    own[i & 1].include(p);
  }
  own[0].include(own[1]);
  return own[0];
}

/// Sets the bounds, and the largest coordinate relative to the centre.
void setBounds(const assets::Bounds& bounds, MeshExtent& extent) {
  extent.bounds = bounds;
  const glm::dvec3 furthest =
      glm::max(glm::abs(bounds.max - extent.centre), glm::abs(bounds.min - extent.centre));
  extent.largest = roundUp(std::max({furthest.x, furthest.y, furthest.z}));
}

}  // namespace

int workersFor(std::size_t triangles, int threads) {
  if (triangles <= kThreadsPay) return 1;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return std::min(threads > 0 ? threads : cores, kMaxWorkers);
}

MeshExtent extentOf(const assets::Mesh& mesh, int workers) {
  std::array<assets::Bounds, kMaxWorkers> shares;
  inParallel(mesh.positions.size(), workers, [&](std::size_t begin, std::size_t end, int worker) {
    shares[static_cast<std::size_t>(worker)] = boundsOf(mesh, begin, end);
  });
  assets::Bounds bounds;
  for (const assets::Bounds& share : shares) bounds.include(share);
  MeshExtent extent;
  extent.centre = 0.5 * (bounds.min + bounds.max);
  setBounds(bounds, extent);
  return extent;
}

void BvhFit::fit(int workers, bool haveMoved) {
  ASSERT(workers > 0 && workers <= kMaxWorkers && !nodes_.empty());
  std::barrier ready(workers);
  // The blocks do not depend on the number of threads, so the slabs do not either.
  const std::size_t blocks = (nodes_.size() + kSlabBlock - 1) / kSlabBlock;
  onThreads(workers, [&](int worker) {
    const auto w = static_cast<std::size_t>(worker), n = static_cast<std::size_t>(workers);
    fitLeaves(nodes_.size() * w / n, nodes_.size() * (w + 1) / n, haveMoved);
    ready.arrive_and_wait();
    if (haveMoved) {
      // Two serial steps run at the same time.
      if (worker == 0) fitInner();
      if (worker == workers - 1) {
        setBounds(boundsOf(mesh_, 0, mesh_.positions.size()), extent_);
      }
      ready.arrive_and_wait();
    }
    for (std::size_t i = blocks * w / n; i < blocks * (w + 1) / n; ++i) {
      fitInnerSlabs(i * kSlabBlock, std::min(nodes_.size(), (i + 1) * kSlabBlock));
    }
  });
}

void BvhFit::fitLeaves(std::size_t begin, std::size_t end, bool haveMoved) {
  ASSERT(begin <= end && end <= nodes_.size());
  for (std::size_t i = begin; i < end; ++i) {
    TriangleBvh::Node& node = nodes_[i];
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t child = node.child[k];
      node.slab[k] = 0;
      if (child == TriangleBvh::kEmptyChild || (child & TriangleBvh::kLeafBit) == 0) continue;
      const std::uint32_t count = TriangleBvh::leafCount(child);
      const Triangles4 triangles =
          leafTriangles(mesh_, order_.data() + (child & TriangleBvh::kLeafFirstMask), count, extent_.centre);
      if (haveMoved) {
        // The corners were rounded to the nearest float.
        setBox(min(triangles.a, min(triangles.b, triangles.c)),
               max(triangles.a, max(triangles.b, triangles.c)), true, node, k);
      }
      node.slab[k] = slabOfTriangles(triangles, count, boxOf(node, k));
    }
  }
}

void BvhFit::fitInner() {
  // Children stand after their parents.
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    TriangleBvh::Node& node = nodes_[i];
    for (int k = 0; k < 4; ++k) {
      if ((node.child[k] & TriangleBvh::kLeafBit) != 0) continue;
      const TriangleBvh::Node& inner = nodes_[node.child[k]];
      setBox(inner.lows(), inner.highs(), false, node, k);
    }
  }
}

void BvhFit::fitInnerSlabs(std::size_t begin, std::size_t end) {
  for (std::size_t i = end; i-- > begin;) {
    TriangleBvh::Node& node = nodes_[i];
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t child = node.child[k];
      if ((child & TriangleBvh::kLeafBit) != 0 || child >= end) continue;
      const TriangleBvh::Node& inner = nodes_[child];
      node.slab[k] = slabOfNode(inner.lows(), inner.highs(), inner.slab, extent_.largest, boxOf(node, k));
    }
  }
}

}  // namespace tandem::haptics
