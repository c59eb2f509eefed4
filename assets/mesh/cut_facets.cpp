#include "assets/mesh/cut_facets.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::assets {
namespace {

double areaOf(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool contains(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& p) {
  return areaOf(a, b, p) >= 0.0 && areaOf(b, c, p) >= 0.0 && areaOf(c, a, p) >= 0.0;
}

/// How far an ear is from a sliver: its area by the square of its longest edge.
double shapeOf(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  const double longest = std::max({glm::dot(b - a, b - a), glm::dot(c - b, c - b), glm::dot(a - c, a - c)});
  return longest > 0.0 ? areaOf(a, b, c) / longest : 0.0;
}

/// The corner of a polygon whose ear is the best one; the size of the polygon if there is none.
std::size_t bestEar(const std::vector<glm::dvec2>& polygon) {
  const std::size_t n = polygon.size();
  std::size_t best = n;
  double quality = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = (i + n - 1) % n, after = (i + 1) % n;
    const glm::dvec2 &a = polygon[before], &b = polygon[i], &c = polygon[after];
    const double shape = shapeOf(a, b, c);
    if (!(shape > quality)) continue;
    bool free = true;
    for (std::size_t k = 0; k < n && free; ++k)
      free = k == before || k == i || k == after || !contains(a, b, c, polygon[k]);
    if (!free) continue;
    best = i;
    quality = shape;
  }
  return best;
}

}  // namespace

FacetCutter::FacetCutter(const Mesh& mesh, double rounding) : mesh_(mesh) {
  out_.positions = mesh.positions;
  out_.rounding = rounding;
}

void FacetCutter::addPoint(std::uint32_t a, std::uint32_t b, const glm::dvec3& point, double share,
                           std::size_t ruling) {
  cuts_[{a, b}].push_back({static_cast<std::uint32_t>(out_.positions.size()), share, ruling});
  out_.positions.push_back(point);
}

void FacetCutter::walkEdge(std::size_t triangle, std::size_t e, std::vector<Corner>& corners) const {
  const auto& c = mesh_.triangles[triangle];
  const std::size_t next = (e + 1) % 3;
  Corner corner;
  corner.vertex = c[e];
  corner.share[static_cast<int>(e)] = 1.0;
  corners.push_back(corner);
  const auto found = cuts_.find({std::min(c[e], c[next]), std::max(c[e], c[next])});
  if (found == cuts_.end()) return;
  const bool forward = c[e] < c[next];
  const std::vector<Cut>& cuts = found->second;
  for (std::size_t k = 0; k < cuts.size(); ++k) {
    const Cut& cut = cuts[forward ? k : cuts.size() - 1 - k];
    Corner between{cut.vertex, glm::dvec3(0.0), cut.ruling, true};
    between.share[static_cast<int>(next)] = forward ? cut.share : 1.0 - cut.share;
    between.share[static_cast<int>(e)] = forward ? 1.0 - cut.share : cut.share;
    corners.push_back(between);
  }
}

void FacetCutter::addPiece(std::size_t triangle, const Corner& a, const Corner& b, const Corner& c,
                           const std::function<glm::vec3(const glm::dvec3&)>* normalAt) {
  if (a.vertex == b.vertex || b.vertex == c.vertex || c.vertex == a.vertex) return;
  out_.triangles.push_back({a.vertex, b.vertex, c.vertex});
  out_.triangleMaterial.push_back(mesh_.triangleMaterial[triangle]);
  const std::array<const Corner*, 3> corners = {&a, &b, &c};
  const auto mean = [](const auto& of, const glm::dvec3& share) {
    return of[0] * static_cast<float>(share.x) + of[1] * static_cast<float>(share.y) +
           of[2] * static_cast<float>(share.z);
  };
  if (!mesh_.triangleUv.empty()) {
    auto& uv = out_.triangleUv.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) uv[k] = mean(mesh_.triangleUv[triangle], corners[k]->share);
  }
  if (mesh_.triangleNormal.empty()) return;
  auto& normals = out_.triangleNormal.emplace_back();
  const auto& own = mesh_.triangleNormal[triangle];
  const bool stated = glm::dot(own[0], own[0]) * glm::dot(own[1], own[1]) * glm::dot(own[2], own[2]) > 0.0f;
  for (std::size_t k = 0; k < 3; ++k) {
    glm::vec3 normal = mean(own, corners[k]->share);
    if (stated && corners[k]->isNew && normalAt != nullptr)
      normal = (*normalAt)(out_.positions[corners[k]->vertex]);
    const float length = glm::length(normal);
    normals[k] = !corners[k]->isNew || !(length > 0.0f) ? normal : normal / length;
  }
}

void FacetCutter::addRound(std::size_t triangle, const RulingOf& ruling,
                           const std::function<glm::vec3(const glm::dvec3&)>& normalAt) {
  const auto& c = mesh_.triangles[triangle];
  const auto count = static_cast<std::int64_t>(ruling.count);
  const auto first = static_cast<std::int64_t>(ruling.at->at(c[0]));
  // Rulings ahead of that of the first corner, below 0 behind it.
  const auto ahead = [&](std::size_t at) {
    const std::int64_t d = (static_cast<std::int64_t>(at) - first + count) % count;
    return d > count / 2 ? d - count : d;
  };
  std::array<std::int64_t, 3> place;
  for (std::size_t k = 0; k < 3; ++k) place[k] = ahead(ruling.at->at(c[k]));
  const std::size_t low =
      static_cast<std::size_t>(std::min_element(place.begin(), place.end()) - place.begin());
  // Around from the lowest corner; a chain of one edge and one of two lead to the highest.
  std::vector<Corner> around;
  std::vector<std::int64_t> at;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t e = (low + k) % 3, begin = around.size();
    walkEdge(triangle, e, around);
    at.push_back(place[e]);
    for (std::size_t i = begin + 1; i < around.size(); ++i) at.push_back(ahead(around[i].ruling));
  }
  const std::size_t n = around.size();
  const auto top = static_cast<std::size_t>(std::max_element(at.begin(), at.end()) - at.begin());
  // The right chain goes up from 0, the left one down from n, which is 0 again.
  std::size_t right = 0, left = n;
  while (right < top || left > top) {
    const bool goRight = left == top || (right < top && at[right + 1] <= at[left - 1]);
    const Corner &r = around[right], &l = around[left % n];
    if (goRight) {
      addPiece(triangle, r, around[right + 1], l, &normalAt);
      ++right;
    } else {
      addPiece(triangle, r, around[left - 1], l, &normalAt);
      --left;
    }
  }
}

bool FacetCutter::addFlat(std::size_t triangle) {
  std::vector<Corner> corners;
  for (std::size_t e = 0; e < 3; ++e) walkEdge(triangle, e, corners);
  if (corners.size() == 3) {
    addPiece(triangle, corners[0], corners[1], corners[2]);
    return true;
  }
  const auto& c = mesh_.triangles[triangle];
  const glm::dvec3 &p = mesh_.positions[c[0]], along = mesh_.positions[c[1]] - p;
  const glm::dvec3 normal = glm::cross(along, mesh_.positions[c[2]] - p);
  if (!(glm::dot(normal, normal) > 0.0)) return false;
  const glm::dvec3 x = glm::normalize(along), y = glm::normalize(glm::cross(normal, x));
  std::vector<glm::dvec2> polygon;
  for (const Corner& corner : corners) {
    const glm::dvec3 offset = out_.positions[corner.vertex] - p;
    polygon.emplace_back(glm::dot(offset, x), glm::dot(offset, y));
  }
  while (corners.size() >= 3) {
    const std::size_t i = bestEar(polygon), n = corners.size();
    if (i == n) return false;
    addPiece(triangle, corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]);
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(i));
    polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return true;
}

}  // namespace tandem::assets
