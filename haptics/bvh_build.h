#pragma once

// The construction behind TriangleBvh; nobody else includes this.

#include <cstdint>
#include <memory>
#include <vector>

#include "haptics/triangle_bvh.h"

namespace tandem::haptics {

/// The box of one triangle, rounded outwards, relative to the mesh's centre. 32 bytes: two SSE loads.
struct alignas(16) BuildPrimitive {
  float low[3];
  std::uint32_t tagged;
  float high[3];
  float unused;  // a normal number too

  // The index shares a register with floats: the tag makes its bits those of a normal number, never a slow
  // denormal.
  static constexpr std::uint32_t kTag = 0x40000000u;
  void setTriangle(std::uint32_t index) { tagged = index | kTag; }
  std::uint32_t triangle() const { return tagged & ~kTag; }
};

struct BuiltTree {
  std::unique_ptr<TriangleBvh::Node[]> nodes;  // children stand after their parents; no slabs yet
  std::uint32_t nodeCount = 0;
  std::vector<std::uint32_t> order;  // triangles in leaf order
};

/// Boxes are relative to `centre`. The tree does not depend on the number of threads.
BuiltTree buildTree(const assets::Mesh& mesh, const glm::dvec3& centre, int threads);

}  // namespace tandem::haptics
