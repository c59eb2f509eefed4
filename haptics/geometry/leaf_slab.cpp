#include "haptics/geometry/leaf_slab.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

/// std::round() for small numbers, without the call.
float nearestWhole(float x) { return static_cast<float>(static_cast<int>(x + std::copysign(0.5f, x))); }

/// std::ceil() for small numbers.
int wholeAbove(float x) {
  const int whole = static_cast<int>(x);
  return whole + (static_cast<float>(whole) < x ? 1 : 0);
}

/// The direction in steps of 1/127 of its largest component; zero for a zero vector.
glm::vec3 quantised(const glm::vec3& direction) {
  const float largest =
      std::max(std::abs(direction.x), std::max(std::abs(direction.y), std::abs(direction.z)));
  if (!(largest > 0.0f && largest < 1e35f)) return glm::vec3(0.0f);
  const float scale = 127.0f / largest;
  if (!(scale < 1e35f)) return glm::vec3(0.0f);
  return {nearestWhole(direction.x * scale), nearestWhole(direction.y * scale),
          nearestWhole(direction.z * scale)};
}

/// Packs a slab; 0 where the slab bounds no more tightly than the box, whose reach along the same normal is
/// `reach`.
std::uint32_t pack(const glm::vec3& normal, float offset, float reach) {
  if (!(reach > 0.0f) || !(offset < reach)) return 0;
  const int height = wholeAbove(std::max(-128.0f, 128.0f * (offset / reach) + 1e-3f));
  if (height > 127) return 0;
  const auto byte = [](float x) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(x)) & 0xffu; };
  return byte(normal.x) | byte(normal.y) << 8 | byte(normal.z) << 16 |
         (static_cast<std::uint32_t>(height) & 0xffu) << 24;
}

float reachOf(const glm::vec3& normal, const FloatBox& box) {
  return glm::dot(glm::abs(normal), box.extent());
}

Vec4 inAllLanes(const glm::vec3& v) { return {Float4(v.x), Float4(v.y), Float4(v.z)}; }

float sum(Float4 v) {
  alignas(16) float f[4];
  v.store(f);
  return (f[0] + f[1]) + (f[2] + f[3]);
}

}  // namespace

std::uint32_t slabOfTriangles(const Triangles4& t, std::uint32_t count, const FloatBox& box) {
  ASSERT(count <= 4);
  alignas(16) static constexpr float kLanes[5][4] = {
      {}, {1.0f}, {1.0f, 1.0f}, {1.0f, 1.0f, 1.0f}, {1.0f, 1.0f, 1.0f, 1.0f}};
  const Vec4 twice = cross(t.b - t.a, t.c - t.a) * Float4::load(kLanes[count]);
  const glm::vec3 normal = quantised({sum(twice.x), sum(twice.y), sum(twice.z)});
  const glm::vec3 centre = box.centre();
  const Vec4 c = inAllLanes(centre), u = inAllLanes(normal);
  alignas(16) float heights[4];
  max(dot(u, t.a - c), max(dot(u, t.b - c), dot(u, t.c - c))).store(heights);
  const float highest = std::max(std::max(heights[0], heights[1]), std::max(heights[2], heights[3]));
  const glm::vec3 furthest = glm::max(glm::abs(box.low), glm::abs(box.high));
  const float rounding = 0x1p-22f * glm::dot(glm::abs(normal), furthest);
  return pack(normal, highest + rounding, reachOf(normal, box));
}

std::uint32_t slabOfNode(const Vec4& low, const Vec4& high, const std::uint32_t* slabs, float largest,
                         const FloatBox& box) {
  const Float4 half(0.5f);
  const Vec4 extent = (high - low) * half;
  const Slab4 inner = unpackSlabs(slabs, extent);
  const glm::vec3 normal = quantised({sum(inner.normal.x), sum(inner.normal.y), sum(inner.normal.z)});
  const glm::vec3 centre = box.centre();
  const Vec4 u = inAllLanes(normal);
  const Vec4 offset = (low + high) * half - inAllLanes(centre);
  const Float4 square = max(dot(inner.normal, inner.normal), Float4(1e-37f));
  const Float4 along = max(dot(u, inner.normal), Float4()) / square;
  const Float4 height = dot(u, offset) + along * inner.offset + dot(abs(u - inner.normal * along), extent);
  alignas(16) float heights[4], lows[4], highs[4];
  height.store(heights);
  low.x.store(lows);
  high.x.store(highs);
  float highest = -1e30f;
  for (int i = 0; i < 4; ++i) {
    if (lows[i] <= highs[i]) highest = std::max(highest, heights[i]);
  }
  return pack(normal, highest + glm::length(normal) * largest * 0x1p-20f, reachOf(normal, box));
}

}  // namespace tandem::haptics
