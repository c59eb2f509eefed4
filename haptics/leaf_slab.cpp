#include "haptics/leaf_slab.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

/// The direction in steps of 1/127 of its largest component; zero if it has none.
glm::dvec3 quantised(const glm::dvec3& direction) {
  const double largest = std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
  if (!(largest > 0.0) || !std::isfinite(largest)) return glm::dvec3(0.0);
  return glm::round(direction * (127.0 / largest));
}

/// 0 where the slab would say no more than the box.
std::uint32_t pack(const glm::dvec3& normal, double offset, double reach) {
  if (!(reach > 0.0) || !(offset < reach)) return 0;
  const int height = std::max(-128, static_cast<int>(std::ceil(128.0 * offset / reach + 1e-3)));
  if (height > 127) return 0;
  const auto byte = [](double x) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(x)) & 0xffu; };
  return byte(normal.x) | byte(normal.y) << 8 | byte(normal.z) << 16 | byte(height) << 24;
}

}  // namespace

std::uint32_t slabOfTriangles(std::span<const Triangle> triangles, const glm::dvec3& origin,
                              const FloatBox& box) {
  glm::dvec3 sum(0.0);
  for (const Triangle& t : triangles) sum += glm::cross(t.b - t.a, t.c - t.a);
  const glm::dvec3 normal = quantised(sum), centre(box.centre()), from = origin + centre;
  const double reach = glm::dot(glm::abs(normal), glm::dvec3(box.extent()));
  double offset = -reach;
  for (const Triangle& t : triangles) {
    for (const glm::dvec3& p : {t.a, t.b, t.c}) offset = std::max(offset, glm::dot(normal, p - from));
  }
  return pack(normal, offset, reach);
}

std::uint32_t slabOfNode(const Vec4& low, const Vec4& high, const std::uint32_t* slabs, float largest,
                         const FloatBox& box) {
  const Float4 half(0.5f);
  const Vec4 extent = (high - low) * half;
  const Slab4 inner = unpackSlabs(slabs, extent);
  const auto sum = [](Float4 v) {
    alignas(16) float f[4];
    v.store(f);
    return static_cast<double>(f[0] + f[1] + f[2] + f[3]);
  };
  const glm::dvec3 normal = quantised({sum(inner.normal.x), sum(inner.normal.y), sum(inner.normal.z)});
  const glm::vec3 centre = box.centre(), n(normal);
  const Vec4 u{Float4(n.x), Float4(n.y), Float4(n.z)};
  const Vec4 offset = (low + high) * half - Vec4{Float4(centre.x), Float4(centre.y), Float4(centre.z)};
  const Float4 square = max(dot(inner.normal, inner.normal), Float4(1e-37f));
  const Float4 along = max(dot(u, inner.normal), Float4()) / square;
  const Float4 height = dot(u, offset) + along * inner.offset + dot(abs(u - inner.normal * along), extent);
  alignas(16) float heights[4], lows[4], highs[4];
  height.store(heights);
  low.x.store(lows);
  high.x.store(highs);
  double highest = -1e30;
  for (int i = 0; i < 4; ++i) {
    if (lows[i] <= highs[i]) highest = std::max(highest, static_cast<double>(heights[i]));
  }
  const double reach = glm::dot(glm::abs(normal), glm::dvec3(box.extent()));
  return pack(normal, highest + glm::length(normal) * static_cast<double>(largest) * 0x1p-20, reach);
}

}  // namespace tandem::haptics
