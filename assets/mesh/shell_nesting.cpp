#include "assets/mesh/shell_nesting.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tandem::assets {
namespace {

/// Twice the signed area of (a, b, p) seen along z, with p moved by an infinitesimal (e, e^2) so that it
/// never is zero for a != b, and the same for both triangles of an edge but for its sign.
bool isLeftOf(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p) {
  const bool swapped = b.x < a.x || (b.x == a.x && b.y < a.y);
  const glm::dvec3 &low = swapped ? b : a, &high = swapped ? a : b;
  const double area = (high.x - low.x) * (p.y - low.y) - (high.y - low.y) * (p.x - low.x);
  bool left = area > 0.0;
  if (area == 0.0) left = high.y != low.y ? high.y < low.y : high.x > low.x;
  return left != swapped;
}

/// Whether the ray from p along +z meets the triangle; `height` is where.
bool rayMeets(const std::array<glm::dvec3, 3>& t, const glm::dvec3& p, double& height) {
  const bool side = isLeftOf(t[0], t[1], p);
  if (isLeftOf(t[1], t[2], p) != side || isLeftOf(t[2], t[0], p) != side) return false;
  const glm::dvec3 ab = t[1] - t[0], ac = t[2] - t[0];
  const double nx = ab.y * ac.z - ab.z * ac.y, ny = ab.z * ac.x - ab.x * ac.z, nz = ab.x * ac.y - ab.y * ac.x;
  if (nz == 0.0) return false;
  height = t[0].z - (nx * (p.x - t[0].x) + ny * (p.y - t[0].y)) / nz;
  return height > p.z;
}

/// The triangles of closed shells, sorted into a square grid over x and y.
class ColumnGrid {
 public:
  ColumnGrid(const Mesh& mesh, const std::vector<Shell>& shells) : mesh_(mesh) {
    setSide(std::clamp(static_cast<int>(std::sqrt(static_cast<double>(mesh.triangles.size()))), 1, 1024));
    // Large triangles lie in many columns. If a file has only large triangles, coarser columns bound the
    // memory.
    while (side_ > 1 && entries(shells) > 8 * mesh.triangles.size() + 65536) setSide(side_ / 2);
    columns_.resize(static_cast<std::size_t>(side_) * side_);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      if (shells[mesh.triangleShell[t]].closed) add(t);
  }

  /// Triangles above or below a point.
  const std::vector<std::uint32_t>& column(const glm::dvec3& p) const {
    return columns_[static_cast<std::size_t>(cell(p, 1)) * side_ + cell(p, 0)];
  }

  std::array<glm::dvec3, 3> corners(std::uint32_t t) const {
    const TriangleIndices& v = mesh_.triangles[t];
    return {mesh_.positions[v[0]], mesh_.positions[v[1]], mesh_.positions[v[2]]};
  }

 private:
  int cell(const glm::dvec3& p, int axis) const {
    const double scaled = (p[axis] - mesh_.bounds.min[axis]) * cellsPerMetre_[axis];
    return std::clamp(static_cast<int>(scaled), 0, side_ - 1);
  }

  void setSide(int side) {
    side_ = side;
    const glm::dvec3 extent = mesh_.bounds.max - mesh_.bounds.min;
    for (int axis = 0; axis < 2; ++axis)
      cellsPerMetre_[axis] = extent[axis] > 0.0 ? side_ / extent[axis] : 0.0;
  }

  struct Cells {
    int lowX = 0, highX = 0, lowY = 0, highY = 0;
  };
  Cells cellsOf(std::uint32_t t) const {
    const auto c = corners(t);
    const glm::dvec3 low = glm::min(glm::min(c[0], c[1]), c[2]), high = glm::max(glm::max(c[0], c[1]), c[2]);
    return {cell(low, 0), cell(high, 0), cell(low, 1), cell(high, 1)};
  }

  /// How many entries the columns would have in all.
  std::size_t entries(const std::vector<Shell>& shells) const {
    std::size_t sum = 0;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (!shells[mesh_.triangleShell[t]].closed) continue;
      const Cells c = cellsOf(t);
      sum += static_cast<std::size_t>(c.highX - c.lowX + 1) * static_cast<std::size_t>(c.highY - c.lowY + 1);
    }
    return sum;
  }

  void add(std::uint32_t t) {
    const Cells c = cellsOf(t);
    for (int y = c.lowY; y <= c.highY; ++y)
      for (int x = c.lowX; x <= c.highX; ++x) columns_[static_cast<std::size_t>(y) * side_ + x].push_back(t);
  }

  const Mesh& mesh_;
  int side_ = 1;
  std::array<double, 2> cellsPerMetre_{};
  std::vector<std::vector<std::uint32_t>> columns_;
};

struct Crossing {
  std::uint32_t shell = 0;
  double height = 0.0;
};

/// The closed shells around shell `inner`, nearest above first, found by a ray from one of its faces.
std::vector<Crossing> shellsAround(const Mesh& mesh, const ColumnGrid& grid, const Shell& inner,
                                   std::uint32_t innerIndex, std::size_t& work) {
  const auto c = grid.corners(inner.firstFace);
  // The point is off the face's middle, because in CAD many edges lie over the middles of other faces.
  const glm::dvec3 p = 0.41 * c[0] + 0.35 * c[1] + 0.24 * c[2];
  std::vector<Crossing> crossings;
  const std::vector<std::uint32_t>& column = grid.column(p);
  work += column.size();
  for (const std::uint32_t t : column) {
    double height = 0.0;
    if (mesh.triangleShell[t] != innerIndex && rayMeets(grid.corners(t), p, height))
      crossings.push_back({mesh.triangleShell[t], height});
  }
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return a.shell != b.shell ? a.shell < b.shell : a.height < b.height;
  });
  // A shell crossed an odd number of times is around the point.
  std::vector<Crossing> around;
  for (std::size_t first = 0, last = 0; first < crossings.size(); first = last) {
    while (last < crossings.size() && crossings[last].shell == crossings[first].shell) ++last;
    if ((last - first) % 2 == 1) around.push_back(crossings[first]);
  }
  return around;
}

}  // namespace

std::vector<bool> shellsToInvert(const Mesh& mesh, const std::vector<Shell>& shells) {
  std::vector<bool> invert(shells.size(), false);
  const auto isNegative = [](const Shell& shell) { return shell.closed && shell.signedVolume < 0.0; };
  // Without a negative shell, every shell is an outside or a solid within another.
  if (std::none_of(shells.begin(), shells.end(), isNegative)) return invert;

  const ColumnGrid grid(mesh, shells);
  // Larger shells first: whatever is around a shell is decided before it.
  std::vector<std::uint32_t> order(shells.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&shells](std::uint32_t a, std::uint32_t b) {
    return std::abs(shells[a].signedVolume) > std::abs(shells[b].signedVolume);
  });
  // Rays are cheap unless a file stacks very many faces over one spot; the remaining shells then count as not
  // nested.
  const std::size_t workLimit = 64 * mesh.triangles.size() + 1'000'000;
  std::size_t work = 0;
  for (const std::uint32_t s : order) {
    if (!shells[s].closed) continue;
    invert[s] = isNegative(shells[s]);
    if (work > workLimit) continue;
    std::uint32_t parent = kNone;
    for (const Crossing& crossing : shellsAround(mesh, grid, shells[s], s, work)) {
      const double volume = std::abs(shells[crossing.shell].signedVolume);
      const bool smaller = parent == kNone || volume < std::abs(shells[parent].signedVolume);
      if (volume > std::abs(shells[s].signedVolume) && smaller) parent = crossing.shell;
    }
    if (parent != kNone) invert[s] = invert[parent];
  }
  return invert;
}

}  // namespace tandem::assets
