#pragma once

// The construction behind TriangleBvh; nobody else includes this.

#include <cstdint>
#include <vector>

#include "haptics/triangle_bvh.h"

namespace tandem::haptics {

/// The box of one triangle, rounded outwards, relative to the mesh's centre. 32 bytes: two SSE loads.
struct alignas(16) BuildPrimitive {
  float low[3];
  std::uint32_t tagged;
  float high[3];
  float unused = 1.0f;

  // The index shares a register with floats: the tag makes its bits those of a normal number, never a slow
  // denormal.
  static constexpr std::uint32_t kTag = 0x40000000u;
  void setTriangle(std::uint32_t index) { tagged = index | kTag; }
  std::uint32_t triangle() const { return tagged & ~kTag; }
};

/// Nodes of a tree over `primitives`, which end in leaf order.
std::vector<TriangleBvh::Node> buildNodes(std::vector<BuildPrimitive>& primitives, int threads);

}  // namespace tandem::haptics
