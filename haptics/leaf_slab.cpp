#include "haptics/leaf_slab.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

/// As std::round(), for small numbers and without the call.
double nearestWhole(double x) { return static_cast<int>(x + std::copysign(0.5, x)); }

/// The smallest whole number that is not below x, for small ones.
int wholeAbove(double x) {
  const int whole = static_cast<int>(x);
  return whole + (static_cast<double>(whole) < x ? 1 : 0);
}

/// The direction in steps of 1/127 of its largest component; zero if it has none.
glm::dvec3 quantised(const glm::dvec3& direction) {
  const double largest = std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
  if (!(largest > 0.0) || !std::isfinite(largest)) return glm::dvec3(0.0);
  const double scale = 127.0 / largest;
  return {nearestWhole(direction.x * scale), nearestWhole(direction.y * scale),
          nearestWhole(direction.z * scale)};
}

/// 0 where the slab would say no more than the box.
std::uint32_t pack(const glm::dvec3& normal, double offset, double reach) {
  if (!(reach > 0.0) || !(offset < reach)) return 0;
  const int height = wholeAbove(std::max(-128.0, 128.0 * offset / reach + 1e-3));
  if (height > 127) return 0;
  const auto byte = [](double x) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(x)) & 0xffu; };
  return byte(normal.x) | byte(normal.y) << 8 | byte(normal.z) << 16 | byte(height) << 24;
}

double reachOf(const glm::dvec3& normal, const FloatBox& box) {
  return glm::dot(glm::abs(normal), glm::dvec3(box.extent()));
}

Vec4 same(const glm::vec3& v) { return {Float4(v.x), Float4(v.y), Float4(v.z)}; }

double sum(Float4 v) {
  alignas(16) float f[4];
  v.store(f);
  return static_cast<double>(f[0] + f[1] + f[2] + f[3]);
}

}  // namespace

std::uint32_t slabOfTriangles(const Triangles4& t, std::uint32_t count, const FloatBox& box) {
  alignas(16) static constexpr float kLanes[5][4] = {
      {}, {1.0f}, {1.0f, 1.0f}, {1.0f, 1.0f, 1.0f}, {1.0f, 1.0f, 1.0f, 1.0f}};
  const Vec4 twice = cross(t.b - t.a, t.c - t.a) * Float4::load(kLanes[count]);
  const glm::dvec3 normal = quantised({sum(twice.x), sum(twice.y), sum(twice.z)});
  const glm::vec3 centre = box.centre(), n(normal);
  const Vec4 c = same(centre), u = same(n);
  alignas(16) float heights[4];
  max(dot(u, t.a - c), max(dot(u, t.b - c), dot(u, t.c - c))).store(heights);
  const float highest = std::max(std::max(heights[0], heights[1]), std::max(heights[2], heights[3]));
  const glm::vec3 furthest = glm::max(glm::abs(box.low), glm::abs(box.high));
  const float rounding = 0x1p-22f * glm::dot(glm::abs(n), furthest);
  return pack(normal, static_cast<double>(highest + rounding), reachOf(normal, box));
}

std::uint32_t slabOfNode(const Vec4& low, const Vec4& high, const std::uint32_t* slabs, float largest,
                         const FloatBox& box) {
  const Float4 half(0.5f);
  const Vec4 extent = (high - low) * half;
  const Slab4 inner = unpackSlabs(slabs, extent);
  const glm::dvec3 normal = quantised({sum(inner.normal.x), sum(inner.normal.y), sum(inner.normal.z)});
  const glm::vec3 centre = box.centre(), n(normal);
  const Vec4 u = same(n);
  const Vec4 offset = (low + high) * half - same(centre);
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
  return pack(normal, highest + glm::length(normal) * static_cast<double>(largest) * 0x1p-20,
              reachOf(normal, box));
}

}  // namespace tandem::haptics
