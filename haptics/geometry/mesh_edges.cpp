#include "haptics/geometry/mesh_edges.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <unordered_map>
#include <utility>

#include <glm/common.hpp>
#include <glm/ext/vector_int3_sized.hpp>
#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/constants.h"
#include "haptics/geometry/border_pairs.h"
#include "haptics/geometry/segment.h"
#include "haptics/geometry/triangle_bvh.h"

namespace tandem::haptics {
namespace {

// Faces whose normals differ by less count as one plane; those of a cylinder of 60,000 segments differ by
// more.
constexpr double kFlat = 1e-4;  // rad
constexpr double kSharp = 0.5;  // rad
constexpr std::size_t kMaxAround = 16;
/// Cosine between two faces below which one is the back of the other.
constexpr double kFolded = -0.9999;
/// Borders up to this share of the diagonal apart belong to one slit.
constexpr double kWidestSlit = 0x1p-14;

std::uint32_t edgeTowards(const assets::Mesh& mesh, std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t e = 0; e < 3; ++e) {
    if (mesh.neighbours[from][e] == to) return e;
  }
  return 0;
}

/// rad from one normal to the other about an edge between them, below 0 where it is concave.
double angleAlong(const glm::dvec3& edge, const glm::dvec3& first, const glm::dvec3& second) {
  return std::atan2(glm::dot(glm::cross(first, second), glm::normalize(edge)), glm::dot(first, second));
}

}  // namespace

MeshEdges::MeshEdges(const assets::Mesh& mesh) : mesh_(&mesh) {
  ASSERT(mesh.neighbours.size() == mesh.triangles.size() && mesh.triangles.size() <= kPlace / 4);
  Beyond beyond = mesh.neighbours;
  const double widest = kWidestSlit * glm::distance(mesh.bounds.min, mesh.bounds.max);
  const std::vector<std::uint32_t> faces = facesBeyondBorders(mesh, widest);
  for (std::size_t i = 0; i < faces.size(); ++i)
    if (faces[i] != assets::kNone) beyond[i / 3][i % 3] = faces[i];
  std::vector<std::array<std::uint32_t, 3>> edgeOf(mesh.triangles.size());
  findEdges(beyond, edgeOf);
  listAround(beyond, edgeOf);
  ASSERT(inGroup_.size() == mesh.triangles.size() + 1);
  kept_.shrink_to_fit();
  borders_.shrink_to_fit();
  around_.shrink_to_fit();
}

/// Fills edgeOf: each triangle's edge as an index into kept_, or kNone where it is flat.
void MeshEdges::findEdges(const Beyond& beyond, std::vector<std::array<std::uint32_t, 3>>& edgeOf) {
  const assets::Mesh& mesh = *mesh_;
  std::vector<glm::dvec3> normals(mesh.triangles.size());
  for (std::uint32_t t = 0; t < normals.size(); ++t) normals[t] = normal(t);
  for (auto& edges : edgeOf) edges.fill(assets::kNone);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t other = beyond[t][e];
      // Each side of a slit has an edge of its own.
      const bool border = mesh.neighbours[t][e] == assets::kNone;
      if (!border && other < t) continue;
      const bool back = other == assets::kNone || (border && glm::dot(normals[t], normals[other]) < kFolded);
      double angle = kPi;
      if (!back) {
        const std::uint32_t a = mesh.triangles[t][e], b = mesh.triangles[t][(e + 1) % 3];
        angle = angleAlong(mesh.positions[b] - mesh.positions[a], normals[t], normals[other]);
        if (!(std::abs(angle) > kFlat)) continue;
      }
      const auto index = static_cast<std::uint32_t>(kept_.size());
      const std::uint32_t at = border ? static_cast<std::uint32_t>(borders_.size()) : 4 * t + e;
      kept_.push_back((border ? kBorder : 0) | (angle < 0.0 ? kConcave : 0) | at);
      if (border) borders_.push_back({t, e, back ? assets::kNone : other, true});
      edgeOf[t][e] = index;
      if (!border) edgeOf[other][edgeTowards(mesh, other, t)] = index;
    }
  }
}

std::array<glm::dvec3, 2> MeshEdges::normals(std::uint32_t index) const {
  const Place at = place(index);
  const glm::dvec3 own = normal(at.triangle);
  if (at.other != assets::kNone) return {own, normal(at.other)};
  const EdgeLine edge = line(index);
  return {own, ofSolid_ ? glm::cross(glm::normalize(edge.b - edge.a), own) : -own};
}

double MeshEdges::angle(std::uint32_t index) const {
  const Place at = place(index);
  if (at.other == assets::kNone) return ofSolid_ ? 0.5 * kPi : kPi;
  const EdgeLine edge = line(index);
  return angleAlong(edge.b - edge.a, normal(at.triangle), normal(at.other));
}

MeshEdges MeshEdges::ofSolid() && {
  ofSolid_ = true;
  return std::move(*this);
}

void MeshEdges::listAround(const Beyond& beyond, const std::vector<std::array<std::uint32_t, 3>>& edgeOf) {
  static_assert(kGroup * kMaxAround <= 0xffff);
  inGroup_.reserve(beyond.size() + 1);
  group_.reserve(beyond.size() / kGroup + 1);
  const auto beginList = [this] {
    if (inGroup_.size() % kGroup == 0) group_.push_back(static_cast<std::uint32_t>(around_.size()));
    inGroup_.push_back(static_cast<std::uint16_t>(around_.size() - group_.back()));
  };
  beginList();
  std::array<std::uint32_t, 10> plane;
  for (std::uint32_t t = 0; t < beyond.size(); ++t) {
    plane[0] = t;
    std::size_t known = 1, ring = 0;
    for (int hop = 0; hop < 2; ++hop) {
      const std::size_t end = known;
      for (; ring < end; ++ring) {
        for (std::uint32_t e = 0; e < 3; ++e) {
          const std::uint32_t other = beyond[plane[ring]][e];
          if (edgeOf[plane[ring]][e] != assets::kNone || other == assets::kNone) continue;
          if (std::find(plane.begin(), plane.begin() + static_cast<std::ptrdiff_t>(known), other) ==
                  plane.begin() + static_cast<std::ptrdiff_t>(known) &&
              known < plane.size())
            plane[known++] = other;
        }
      }
    }
    const std::size_t begin = around_.size();
    for (std::size_t i = 0; i < known; ++i) {
      for (const std::uint32_t edge : edgeOf[plane[i]]) {
        if (edge != assets::kNone && around_.size() - begin < kMaxAround) around_.push_back(edge);
      }
    }
    beginList();
  }
}

double MeshEdges::sharpSpacing(double cube) const {
  const double cell = cube / 3.0;
  const auto keyOf = [](const glm::i64vec3& at) {
    const auto part = [](std::int64_t x) { return static_cast<std::uint64_t>(x) & 0x1fffffu; };
    return part(at.x) | part(at.y) << 21 | part(at.z) << 42;
  };
  struct Cell {
    glm::i64vec3 at;
    double length = 0.0;  // m, of the sharp edges in the cell
  };
  std::unordered_map<std::uint64_t, Cell> cells;
  for (std::uint32_t e = 0; e < count(); ++e) {
    const EdgeLine edge = line(e);
    if (edge.border || std::abs(angle(e)) < kSharp) continue;
    const double length = glm::length(edge.b - edge.a);
    const int pieces = static_cast<int>(std::min(std::ceil(2.0 * length / cell), 1e4));
    for (int i = 0; i < pieces; ++i) {
      const glm::i64vec3 at(glm::floor((edge.a + (edge.b - edge.a) * ((i + 0.5) / pieces)) / cell));
      Cell& in = cells.try_emplace(keyOf(at), Cell{at}).first->second;
      in.length += length / pieces;
    }
  }
  // For each cell: the edge length in the 3 x 3 x 3 cells about it, and its own.
  std::vector<std::pair<double, double>> lengths;
  double sum = 0.0;
  for (const auto& [key, in] : cells) {
    double about = 0.0;
    for (std::int64_t i = 0; i < 27; ++i) {
      const auto near = cells.find(keyOf(in.at + glm::i64vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
      if (near != cells.end()) about += near->second.length;
    }
    lengths.emplace_back(about, in.length);
    sum += in.length;
  }
  std::sort(lengths.begin(), lengths.end(), std::greater<>());
  double before = 0.0;
  for (const auto& [about, own] : lengths) {
    before += own;
    if (2.0 * before >= sum) return std::min(cube, cube * cube / about);
  }
  return cube;
}

std::size_t MeshEdges::memory() const {
  return borders_.size() * sizeof(Place) +
         (kept_.size() + group_.size() + around_.size()) * sizeof(std::uint32_t) +
         inGroup_.size() * sizeof(std::uint16_t);
}

bool isBehind(const MeshEdges& edges, const MeshPoint& nearest, const glm::dvec3& p) {
  const glm::dvec3 off = p - nearest.point;
  if (glm::dot(edges.normal(nearest.triangle), off) >= 0.0) return false;
  if (nearest.onFace) return true;
  const double near = 1e-6 * nearest.distance;
  for (const std::uint32_t i : edges.around(nearest.triangle)) {
    const EdgeLine edge = edges.line(i);
    if (glm::length(nearest.point - closestPointOnSegment(nearest.point, edge.a, edge.b)) > near) continue;
    for (const glm::dvec3& normal : edges.normals(i))
      if (glm::dot(normal, off) >= 0.0) return false;
  }
  return true;
}

}  // namespace tandem::haptics
