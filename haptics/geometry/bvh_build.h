#pragma once

// Construction of a TriangleBvh; only triangle_bvh.cpp and bvh_build.cpp include this.

#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {

/// The box of one triangle, rounded outwards, relative to the mesh's centre. 32 bytes: two SSE loads.
struct alignas(16) BuildPrimitive {
  float low[4];   // the fourth: the bits of the triangle's index
  float high[4];  // the fourth: any normal number

  // The index shares a register with floats. The tag makes its bits those of a normal number, because
  // denormals are slow. Indices are below 2^28, see TriangleBvh::kLeafFirstMask.
  static constexpr std::uint32_t kTag = 0x40000000u;
  void setTriangle(std::uint32_t index) { low[3] = std::bit_cast<float>(index | kTag); }
  std::uint32_t triangle() const { return std::bit_cast<std::uint32_t>(low[3]) & ~kTag; }
};

struct BuiltTree {
  std::unique_ptr<TriangleBvh::Node[]> nodes;  // children stand after their parents; no slabs yet
  std::uint32_t nodeCount = 0;
  std::vector<std::uint32_t> order;  // triangles in leaf order
};

/// Boxes are relative to `centre`. The tree does not depend on the number of threads.
BuiltTree buildTree(const assets::Mesh& mesh, const glm::dvec3& centre, int threads);

}  // namespace tandem::haptics
