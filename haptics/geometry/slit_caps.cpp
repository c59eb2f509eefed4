#include "haptics/geometry/slit_caps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

/// Ear clipping takes quadratic time.
constexpr std::size_t kLongestLoop = 512;
/// Of a loop's extent: heights of ears that differ by less are equal but for the rounding of coordinates.
constexpr double kEqual = 0x1p-20;

/// A directed edge that the mesh lacks to be closed.
struct Missing {
  std::uint32_t from = 0, to = 0;
};

/// The directed edges that are missing for every edge to be used equally often in both directions.
std::vector<Missing> missingEdges(const assets::Mesh& mesh) {
  struct Use {
    std::uint64_t key = 0;
    int forward = 0;
  };
  std::vector<Use> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = t[e], b = t[(e + 1) % 3];
      uses.push_back({std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), a < b ? 1 : -1});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) { return a.key < b.key; });
  std::vector<Missing> missing;
  for (std::size_t first = 0, last = 0; first < uses.size(); first = last) {
    int balance = 0;
    for (; last < uses.size() && uses[last].key == uses[first].key; ++last) balance += uses[last].forward;
    const auto low = static_cast<std::uint32_t>(uses[first].key >> 32);
    const auto high = static_cast<std::uint32_t>(uses[first].key);
    for (; balance > 0; --balance) missing.push_back({high, low});
    for (; balance < 0; ++balance) missing.push_back({low, high});
  }
  return missing;
}

/// Splits directed edges, of which as many enter a vertex as leave it, into simple loops.
std::vector<std::vector<std::uint32_t>> simpleLoops(const std::vector<Missing>& edges) {
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> leaving;
  for (const Missing& edge : edges) leaving[edge.from].push_back(edge.to);
  std::unordered_map<std::uint32_t, std::size_t> place;  // along the current path
  std::vector<std::vector<std::uint32_t>> loops;
  for (const Missing& edge : edges) {
    std::vector<std::uint32_t> path = {edge.from};
    place.clear();
    place[edge.from] = 0;
    while (!path.empty()) {
      auto& next = leaving[path.back()];
      if (next.empty()) {
        place.erase(path.back());
        path.pop_back();
        continue;
      }
      const std::uint32_t to = next.back();
      next.pop_back();
      const auto met = place.find(to);
      if (met == place.end()) {
        place[to] = path.size();
        path.push_back(to);
        continue;
      }
      const std::size_t first = met->second;
      loops.emplace_back(path.begin() + static_cast<std::ptrdiff_t>(first), path.end());
      while (path.size() > first + 1) {
        place.erase(path.back());
        path.pop_back();
      }
    }
  }
  return loops;
}

/// Distance of b from the segment a c.
double heightOver(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 along = c - a;
  const double square = glm::dot(along, along);
  const double t = square > 0.0 ? std::clamp(glm::dot(b - a, along) / square, 0.0, 1.0) : 0.0;
  return glm::distance(b, a + t * along);
}

/// A corner of what is left of a loop, and the distance bound of its side to the next corner from the mesh.
struct Corner {
  std::uint32_t vertex = 0;
  double off = 0.0;  // m
};

/// Clips the flattest ear first, of those within `equal` m of it the first one. False, with nothing added, if
/// a cap would deviate by more than `widest`.
bool capLoop(const assets::Mesh& mesh, const std::vector<std::uint32_t>& loop, double widest, double equal,
             SlitCaps& caps) {
  if (loop.size() > kLongestLoop) return false;
  std::vector<Corner> left;
  for (const std::uint32_t vertex : loop) left.push_back({vertex, 0.0});
  SlitCaps own;
  while (left.size() >= 3) {
    const std::size_t count = left.size();
    std::size_t flattest = 0;
    double least = 1e300, off = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const Corner &before = left[(i + count - 1) % count], &here = left[i], &after = left[(i + 1) % count];
      const double height = heightOver(mesh.positions[before.vertex], mesh.positions[here.vertex],
                                       mesh.positions[after.vertex]);
      // A point of the new side is within the ear's height of the two old ones.
      const double reach = height + std::max(before.off, here.off);
      if (!(reach < least - equal)) continue;
      least = reach;
      flattest = i;
      off = reach;
    }
    if (off > widest) return false;
    const std::size_t before = (flattest + count - 1) % count, after = (flattest + 1) % count;
    own.triangles.push_back({left[before].vertex, left[flattest].vertex, left[after].vertex});
    own.width.push_back(off);
    left[before].off = off;
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(flattest));
  }
  caps.triangles.insert(caps.triangles.end(), own.triangles.begin(), own.triangles.end());
  caps.width.insert(caps.width.end(), own.width.begin(), own.width.end());
  caps.loop.resize(caps.triangles.size(), caps.loop.empty() ? 0 : caps.loop.back() + 1);
  return true;
}

/// The greatest distance of a corner of a loop from its first one, m.
double extentOf(const assets::Mesh& mesh, const std::vector<std::uint32_t>& loop) {
  double extent = 0.0;
  for (const std::uint32_t vertex : loop)
    extent = std::max(extent, glm::distance(mesh.positions[vertex], mesh.positions[loop[0]]));
  return extent;
}

/// Triangles from the first corner of a loop to all its edges. Their widths are not measured.
void fanLoop(const std::vector<std::uint32_t>& loop, SlitCaps& caps) {
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    caps.triangles.push_back({loop[0], loop[i], loop[i + 1]});
    caps.width.push_back(std::numeric_limits<double>::max());
  }
}

}  // namespace

SlitCaps closeAllHoles(const assets::Mesh& mesh) {
  SlitCaps caps;
  for (const std::vector<std::uint32_t>& loop : simpleLoops(missingEdges(mesh))) {
    const double equal = kEqual * extentOf(mesh, loop);
    if (!capLoop(mesh, loop, std::numeric_limits<double>::max(), equal, caps)) fanLoop(loop, caps);
  }
  ASSERT(caps.complete && caps.width.size() == caps.triangles.size());
  return caps;
}

SlitCaps capSlits(const assets::Mesh& mesh, double widest) {
  SlitCaps caps;
  for (const std::vector<std::uint32_t>& loop : simpleLoops(missingEdges(mesh)))
    if (!capLoop(mesh, loop, widest, 0.0, caps)) caps.complete = false;
  ASSERT(caps.width.size() == caps.triangles.size() && caps.loop.size() == caps.triangles.size());
  return caps;
}

}  // namespace tandem::haptics
