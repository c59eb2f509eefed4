#include "assets/mesh/vertex_weld.h"

#include <algorithm>
#include <cmath>

#include "assets/scene/scene.h"

namespace tandem::assets {
namespace {

// Width of a cell of the hash grid in tolerances. It is large enough that few points lie near a wall and
// need a search of the next cell, and small enough that a cell cannot hold very many distinct points.
constexpr double kCellWidth = 8.0;
// The grid's origin in cells. CAD likes coordinates of exactly zero, which must not all lie on a wall.
constexpr double kCellOffset = 0.37;
// A key has 21 bits of each index. Where the tolerance is small for the coordinates, far cells share keys.
constexpr std::int64_t kCellMask = (std::int64_t{1} << 21) - 1;

double maxDistance(const glm::dvec3& a, const glm::dvec3& b) {
  return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

/// The points found so far, in an open-addressing table keyed by grid cell.
class PointGrid {
 public:
  PointGrid(double tolerance, std::size_t expected) : tolerance_(tolerance) {
    std::size_t size = 1024;
    while (size < expected) size *= 2;
    slots_.assign(size, Slot{});
  }

  /// The point at `position`, made if there is none within the tolerance.
  std::uint32_t findOrAdd(const glm::dvec3& position, std::vector<glm::dvec3>& points) {
    std::array<std::int64_t, 3> low{}, home{}, high{};
    for (int axis = 0; axis < 3; ++axis) {
      const double scaled = position[axis] / (kCellWidth * tolerance_) + kCellOffset;
      const double floor = std::floor(scaled);
      const double inCell = (scaled - floor) * kCellWidth;
      home[axis] = static_cast<std::int64_t>(floor);
      low[axis] = home[axis] - (inCell <= 1.0 ? 1 : 0);
      high[axis] = home[axis] + (inCell >= kCellWidth - 1.0 ? 1 : 0);
    }
    const std::uint64_t homeKey = key(home[0], home[1], home[2]);
    std::uint32_t found = search(homeKey, position, points);
    // Points are more than a tolerance apart, so an equal one is the only candidate.
    if (found != kNone && points[found] == position) return found;
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t z = low[2]; z <= high[2]; ++z)
          if (key(x, y, z) != homeKey) found = std::min(found, search(key(x, y, z), position, points));
    if (found != kNone) return found;
    points.push_back(position);
    if (points.size() * 2 > slots_.size()) grow();
    insert({homeKey, static_cast<std::uint32_t>(points.size() - 1)});
    return static_cast<std::uint32_t>(points.size() - 1);
  }

 private:
  struct Slot {
    std::uint64_t cell = 0;
    std::uint32_t point = kNone;
  };

  static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<std::uint64_t>(x & kCellMask) << 42 | static_cast<std::uint64_t>(y & kCellMask) << 21 |
           static_cast<std::uint64_t>(z & kCellMask);
  }

  std::size_t slotOf(std::uint64_t cell) const {
    std::uint64_t h = cell * 0x9e3779b97f4a7c15u;  // Fibonacci hashing; the high bits are the mixed ones
    h ^= h >> 32;
    return h & (slots_.size() - 1);
  }

  /// The first point within the tolerance in one cell, or kNone (which is larger than every index).
  std::uint32_t search(std::uint64_t cell, const glm::dvec3& position,
                       const std::vector<glm::dvec3>& points) const {
    std::uint32_t found = kNone;
    for (std::size_t i = slotOf(cell); slots_[i].point != kNone; i = (i + 1) & (slots_.size() - 1)) {
      if (slots_[i].cell != cell) continue;
      const glm::dvec3& point = points[slots_[i].point];
      if (point == position) return slots_[i].point;
      if (maxDistance(point, position) <= tolerance_) found = std::min(found, slots_[i].point);
    }
    return found;
  }

  void insert(const Slot& slot) {
    std::size_t i = slotOf(slot.cell);
    while (slots_[i].point != kNone) i = (i + 1) & (slots_.size() - 1);
    slots_[i] = slot;
  }

  void grow() {
    std::vector<Slot> old(slots_.size() * 2);
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.point != kNone) insert(slot);
  }

  double tolerance_;
  std::vector<Slot> slots_;
};

}  // namespace

WeldedVertices weldVertices(const std::vector<glm::dvec3>& positions,
                            const std::vector<std::array<std::uint32_t, 3>>& triangles, double rounding) {
  WeldedVertices welded;
  welded.pointOf.assign(positions.size(), kNone);
  double largest = 0.0;
  for (const auto& triangle : triangles)
    for (const std::uint32_t vertex : triangle)
      largest = std::max(largest, maxDistance(positions[vertex], glm::dvec3(0.0)));
  // The coordinates themselves are rounded to doubles.
  rounding = rounding > 0.0 ? std::max(rounding, std::ldexp(largest, -50)) : std::ldexp(largest, -24);
  // Where all used vertices lie at the origin, any tolerance is right.
  welded.tolerance = rounding > 0.0 ? 4.0 * rounding : 1.0;

  PointGrid grid(welded.tolerance, positions.size() / 2);
  for (const auto& triangle : triangles)
    for (const std::uint32_t vertex : triangle)
      if (welded.pointOf[vertex] == kNone)
        welded.pointOf[vertex] = grid.findOrAdd(positions[vertex], welded.points);
  return welded;
}

}  // namespace tandem::assets
