#include "client/levels/level_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace tandem::client {
namespace {

constexpr double kSlack = 1.05;     // a piece this far above what is known already is not divided
constexpr double kFloor = 2e-5;     // of the diagonal: what no picture shows
constexpr int kMostDivisions = 40;  // of a piece into two
constexpr int kHalvings = 10;       // of an edge, for the place where two triangles are equally near

/// A point of `from`, and a triangle of `to` that is near it.
struct Corner {
  glm::dvec3 point{0.0};
  std::uint32_t triangle = 0;
  double distance = 0.0;  // of the two
};
using Piece = std::array<Corner, 3>;

class BoundSearch {
 public:
  BoundSearch(const haptics::TriangleBvh& to, double least) : to_(to), reached_(least), bound_(least) {
    floor_ = kFloor * glm::length(to.mesh().bounds.max - to.mesh().bounds.min);
  }

  /// The nearest triangle of all, thought to be nearer than `within`.
  Corner look(const glm::dvec3& p, double within) {
    haptics::MeshPoint nearest;
    if (!to_.closestPoint(p, within, nearest)) to_.closestPoint(p, 1e300, nearest);
    reached_ = std::max(reached_, nearest.distance);
    return {p, nearest.triangle, nearest.distance};
  }

  void add(const Piece& piece, int divisions = kMostDivisions) {
    double best = std::numeric_limits<double>::max();
    for (std::size_t k = 0; k < 3; ++k)
      if (k == 0 || piece[k].triangle != piece[k - 1].triangle)
        best = std::min(best, furthest(piece, piece[k].triangle));
    if (best <= enough() || divisions == 0) {
      bound_ = std::max(bound_, best);
      return;
    }
    const std::size_t edge = edgeToCut(piece);
    if (edge == 3 || glm::distance(piece[edge].point, piece[(edge + 1) % 3].point) <= floor_) {
      bound_ = std::max(bound_, best);
      return;
    }
    divide(piece, edge, divisions - 1);
  }

  double bound() const { return std::max(bound_, reached_); }

 private:
  double enough() const { return std::max(kSlack * reached_, floor_); }
  double distanceTo(std::uint32_t triangle, const glm::dvec3& p) const {
    return glm::distance(p, haptics::closestPointOnTriangle(p, to_.triangle(triangle)).point);
  }

  double furthest(const Piece& piece, std::uint32_t triangle) const {
    double most = 0.0;
    for (const Corner& corner : piece)
      most =
          std::max(most, corner.triangle == triangle ? corner.distance : distanceTo(triangle, corner.point));
    return most;
  }

  /// The edge whose ends are furthest from each other's triangle; 3 if all ends have the same.
  std::size_t edgeToCut(const Piece& piece) const {
    std::size_t edge = 3;
    double most = -1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner &a = piece[k], &b = piece[(k + 1) % 3];
      if (a.triangle == b.triangle) continue;
      const double apart = std::min(distanceTo(a.triangle, b.point), distanceTo(b.triangle, a.point));
      if (apart <= most) continue;
      edge = k;
      most = apart;
    }
    return edge;
  }

  /// Cuts a piece through edge k, where the triangles of its ends are equally near: if those are neighbours
  /// and near enough there, each side has its own; else the nearest one of all is looked for.
  void divide(const Piece& piece, std::size_t k, int divisions) {
    const Corner &a = piece[k], &b = piece[(k + 1) % 3], &c = piece[(k + 2) % 3];
    double low = 0.0, high = 1.0;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      const glm::dvec3 p = glm::mix(a.point, b.point, middle);
      (distanceTo(a.triangle, p) <= distanceTo(b.triangle, p) ? low : high) = middle;
    }
    const glm::dvec3 p = glm::mix(a.point, b.point, 0.5 * (low + high));
    Corner first{p, a.triangle, distanceTo(a.triangle, p)}, second{p, b.triangle, distanceTo(b.triangle, p)};
    if (std::max(first.distance, second.distance) > enough()) {
      const double within = std::min(first.distance, second.distance);
      first = second = look(glm::mix(a.point, b.point, 0.5), within + glm::distance(a.point, b.point));
    }
    add({a, first, c}, divisions);
    add({second, b, c}, divisions);
  }

  const haptics::TriangleBvh& to_;
  double reached_;  // by a point of `from`, or given
  double bound_, floor_ = 0.0;
};

}  // namespace

double distanceBound(const assets::Mesh& from, const haptics::TriangleBvh& to, double least) {
  if (from.triangles.empty() || to.empty()) return least;
  BoundSearch search(to, least);
  const double size = glm::length(to.mesh().bounds.max - to.mesh().bounds.min);
  std::vector<Corner> corners;
  corners.reserve(from.positions.size());
  double within = 0.01 * size;
  for (const glm::dvec3& p : from.positions) {
    corners.push_back(search.look(p, within));
    within = 4.0 * corners.back().distance + 1e-3 * size;
  }
  for (const auto& t : from.triangles) search.add({corners[t[0]], corners[t[1]], corners[t[2]]});
  return search.bound();
}

double sampledDistance(const assets::Mesh& from, const haptics::TriangleBvh& to, double spacing) {
  double most = 0.0;
  haptics::MeshPoint nearest;
  for (const auto& t : from.triangles) {
    const glm::dvec3 &a = from.positions[t[0]], &b = from.positions[t[1]], &c = from.positions[t[2]];
    const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    const int rows = std::max(1, static_cast<int>(std::ceil(longest / spacing)));
    double within = spacing;
    for (int i = 0; i <= rows; ++i)
      for (int j = 0; j <= rows - i; ++j) {
        const double u = static_cast<double>(i) / rows, v = static_cast<double>(j) / rows;
        const glm::dvec3 p = (1.0 - u - v) * a + u * b + v * c;
        if (!to.closestPoint(p, within, nearest)) to.closestPoint(p, 1e300, nearest);
        most = std::max(most, nearest.distance);
        within = nearest.distance + 2.0 * spacing;
      }
  }
  return most;
}

double meanEdge(const assets::Mesh& mesh) {
  double edges = 0.0;
  for (const auto& t : mesh.triangles) edges += glm::distance(mesh.positions[t[0]], mesh.positions[t[1]]);
  return mesh.triangles.empty() ? 0.0 : edges / static_cast<double>(mesh.triangles.size());
}

double levelError(const assets::Mesh& exact, const haptics::TriangleBvh& exactTree, double spacing,
                  const assets::Mesh& level, const haptics::TriangleBvh& levelTree) {
  const double back = sampledDistance(level, exactTree, spacing);
  return std::max(distanceBound(exact, levelTree, back),
                  kFloor * glm::length(exact.bounds.max - exact.bounds.min));
}

}  // namespace tandem::client
