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

}  // namespace

MeshEdges::MeshEdges(const assets::Mesh& mesh) : mesh_(&mesh) {
  ASSERT(mesh.neighbours.size() == mesh.triangles.size());
  normals_.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& c = mesh.triangles[t];
    const glm::dvec3 area =
        glm::cross(mesh.positions[c[1]] - mesh.positions[c[0]], mesh.positions[c[2]] - mesh.positions[c[0]]);
    const double length = glm::length(area);
    normals_[t] = length > 0.0 ? area / length : glm::dvec3(0.0);
  }
  Beyond beyond = mesh.neighbours;
  const double widest = kWidestSlit * glm::distance(mesh.bounds.min, mesh.bounds.max);
  const std::vector<std::uint32_t> faces = facesBeyondBorders(mesh, widest);
  for (std::size_t i = 0; i < faces.size(); ++i)
    if (faces[i] != assets::kNone) beyond[i / 3][i % 3] = faces[i];
  std::vector<std::array<std::uint32_t, 3>> edgeOf(mesh.triangles.size());
  findEdges(mesh, beyond, edgeOf);
  listAround(beyond, edgeOf);
  ASSERT(first_.size() == mesh.triangles.size() + 1 && first_.back() == around_.size());
  kept_.shrink_to_fit();
  backs_.shrink_to_fit();
  around_.shrink_to_fit();
}

/// Fills edgeOf: each triangle's edge as an index into kept_, or kNone where it is flat.
void MeshEdges::findEdges(const assets::Mesh& mesh, const Beyond& beyond,
                          std::vector<std::array<std::uint32_t, 3>>& edgeOf) {
  for (auto& edges : edgeOf) edges.fill(assets::kNone);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t other = beyond[t][e];
      // Each side of a slit has an edge of its own.
      const bool border = mesh.neighbours[t][e] == assets::kNone;
      if (!border && other < t) continue;
      const std::uint32_t ia = mesh.triangles[t][e], ib = mesh.triangles[t][(e + 1) % 3];
      Kept kept{{ia, ib}, {t, other}, 0.0, border};
      if (other == assets::kNone || (border && glm::dot(normals_[t], normals_[other]) < kFolded)) {
        kept.triangles[1] = t;
        kept.angle = std::acos(-1.0);
        kept.back = static_cast<std::uint32_t>(backs_.size());
        backs_.push_back(-normals_[t]);
      } else {
        const glm::dvec3 along = glm::normalize(mesh.positions[ib] - mesh.positions[ia]);
        kept.angle = std::atan2(glm::dot(glm::cross(normals_[t], normals_[other]), along),
                                glm::dot(normals_[t], normals_[other]));
        if (!(std::abs(kept.angle) > kFlat)) continue;
      }
      const auto index = static_cast<std::uint32_t>(kept_.size());
      kept_.push_back(kept);
      edgeOf[t][e] = index;
      if (!border) edgeOf[other][edgeTowards(mesh, other, t)] = index;
    }
  }
}

MeshEdges MeshEdges::ofSolid() && {
  for (Kept& kept : kept_) {
    if (kept.back == assets::kNone) continue;
    const glm::dvec3 along = glm::normalize(mesh_->positions[kept.ends[1]] - mesh_->positions[kept.ends[0]]);
    backs_[kept.back] = glm::cross(along, normals_[kept.triangles[0]]);
    kept.angle = 0.5 * std::acos(-1.0);
  }
  return std::move(*this);
}

void MeshEdges::listAround(const Beyond& beyond, const std::vector<std::array<std::uint32_t, 3>>& edgeOf) {
  first_.reserve(beyond.size() + 1);
  first_.push_back(0);
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
    first_.push_back(static_cast<std::uint32_t>(around_.size()));
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
    const MeshEdge edge = this->edge(e);
    if (std::abs(edge.angle) < kSharp || edge.border) continue;
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
  return kept_.size() * sizeof(Kept) + (normals_.size() + backs_.size()) * sizeof(glm::dvec3) +
         (first_.size() + around_.size()) * sizeof(std::uint32_t);
}

bool isBehind(const MeshEdges& edges, const MeshPoint& nearest, const glm::dvec3& p) {
  const glm::dvec3 off = p - nearest.point;
  if (glm::dot(edges.normal(nearest.triangle), off) >= 0.0) return false;
  if (nearest.onFace) return true;
  const double near = 1e-6 * nearest.distance;
  for (const std::uint32_t i : edges.around(nearest.triangle)) {
    const MeshEdge edge = edges.edge(i);
    if (glm::length(nearest.point - closestPointOnSegment(nearest.point, edge.a, edge.b)) > near) continue;
    for (const glm::dvec3& normal : edge.normals)
      if (glm::dot(normal, off) >= 0.0) return false;
  }
  return true;
}

}  // namespace tandem::haptics
