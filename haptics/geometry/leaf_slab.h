#pragma once

// Slabs: the flatness of a BVH leaf in four bytes. Boxes of triangles askew to the axes are thick, and
// without slabs a ball that slides over a surface of small triangles would test hundreds of them. See
// TriangleBvh::Node::slab.

#include <cstdint>

#include <glm/vec3.hpp>

#include "haptics/base/simd4.h"
#include "haptics/geometry/triangle_filter.h"

namespace tandem::haptics {

/// A box of a BVH, m; centre and extent in float, as queries compute them.
struct FloatBox {
  glm::vec3 low, high;
  glm::vec3 centre() const { return (low + high) * 0.5f; }
  glm::vec3 extent() const { return (high - low) * 0.5f; }
};

/// The slab, along their mean normal, of the first `count` of four triangles (the others repeat one of them)
/// whose box is `box`. Corners and box are relative to the same point, the corners rounded to float.
std::uint32_t slabOfTriangles(const Triangles4& triangles, std::uint32_t count, const FloatBox& box);

/// The slab of a node's four children, given their boxes and slabs (an empty child has low > high), which lie
/// in `box`. `largest` is the largest coordinate, m.
std::uint32_t slabOfNode(const Vec4& low, const Vec4& high, const std::uint32_t* slabs, float largest,
                         const FloatBox& box);

/// Four slabs: normal . (x - centre) <= offset.
struct Slab4 {
  Vec4 normal;  // not a unit vector
  Float4 offset;
};

inline Slab4 unpackSlabs(const std::uint32_t* slabs, const Vec4& extent) {
  const Vec4 normal{signedBytes(slabs, 0), signedBytes(slabs, 1), signedBytes(slabs, 2)};
  return {normal, signedBytes(slabs, 3) * Float4(1.0f / 128.0f) * dot(abs(normal), extent)};
}

}  // namespace tandem::haptics
