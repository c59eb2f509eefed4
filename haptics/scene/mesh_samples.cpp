#include "haptics/scene/mesh_samples.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "haptics/geometry/outward.h"

namespace tandem::haptics {
namespace {

// Cells over which a smooth surface turns as much as counts for the sample of one.
constexpr double kBeyondCell = 1.5;
// Facings of samples in a cell, along an axis from the middle to either end: each takes some 30 degrees.
constexpr double kFacings = 2.0;

/// A grid whose cells each hold at most one sample for the places that face one way: a small rounding turns
/// by a right angle within a cell.
class Thinning {
 public:
  Thinning(const glm::dvec3& origin, double cell) : origin_(origin), cell_(cell) {}
  /// The sample in the cell of p, of those that face like it; `sample` where there was none.
  std::uint32_t sampleAt(const glm::dvec3& p, const glm::dvec3& facing, std::uint32_t sample) {
    const glm::dvec3 q = glm::floor((p - origin_) / cell_), n = glm::round(kFacings * facing);
    const auto part = [](double x, std::uint64_t bits) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(x)) & bits;
    };
    const auto at = [&](double x, double facingX) { return part(x, 0x3ffffu) << 3 | part(facingX, 7u); };
    return samples_.emplace(at(q.x, n.x) | at(q.y, n.y) << 21 | at(q.z, n.z) << 42, sample).first->second;
  }

 private:
  glm::dvec3 origin_;
  double cell_;
  std::unordered_map<std::uint64_t, std::uint32_t> samples_;
};

void addDistinct(std::vector<glm::dvec3>& normals, std::size_t first, const glm::dvec3& normal) {
  for (std::size_t i = first; i < normals.size(); ++i) {
    if (glm::dot(normals[i], normal) > 1.0 - 1e-6) return;
  }
  normals.push_back(normal);
}

/// Samples the convex edges, corners and smooth convex surfaces of a mesh.
class MeshSampler {
 public:
  MeshSampler(const assets::Mesh& mesh, const MeshEdges& edges, double spacing, double smoothSpacing,
              double sharp)
      : mesh_(mesh),
        edges_(edges),
        spacing_(spacing),
        smoothSpacing_(smoothSpacing),
        sharp_(sharp),
        sharpEdge_(edges.count(), false) {}

  SampleSet sample() {
    std::vector<bool> sampled(mesh_.positions.size(), false);
    sampleSharpEdges(sampled);
    addCorners(sampled);
    sampleSmooth(sampled);
    return std::move(out_);
  }

 private:
  /// Samples the interior of sharp edges; marks the ends of those edges in `corner`.
  void sampleSharpEdges(std::vector<bool>& corner);
  /// Adds one sample at each marked vertex, with the normals of all faces at its convex edges.
  void addCorners(const std::vector<bool>& corner);
  /// Samples the edges of smooth convex surfaces, one a cell of a grid, except at the vertices in `sampled`.
  void sampleSmooth(std::vector<bool>& sampled);

  const assets::Mesh& mesh_;
  const MeshEdges& edges_;
  const double spacing_, smoothSpacing_;  // m
  const double sharp_;                    // rad
  std::vector<bool> sharpEdge_;           // of each edge, once the sharp ones are sampled
  SampleSet out_;
};

void MeshSampler::sampleSharpEdges(std::vector<bool>& corner) {
  for (std::uint32_t i = 0; i < edges_.count(); ++i) {
    if (!edges_.isConvex(i) || edges_.angle(i) < sharp_) continue;
    sharpEdge_[i] = true;
    const EdgeLine edge = edges_.line(i);
    corner[edge.ends[0]] = corner[edge.ends[1]] = true;
    const double length = glm::length(edge.b - edge.a);
    const int inner = std::max(1, static_cast<int>(std::ceil(length / spacing_)) - 1);
    const auto first = static_cast<std::uint32_t>(out_.normals.size());
    const auto normals = edges_.normals(i);
    out_.normals.insert(out_.normals.end(), normals.begin(), normals.end());
    for (int k = 1; k <= inner; ++k) {
      out_.samples.push_back({edge.a + (edge.b - edge.a) * (static_cast<double>(k) / (inner + 1)), first, 2,
                              i, edge.triangles[0], roundUp(length / (inner + 1))});
    }
  }
}

void MeshSampler::addCorners(const std::vector<bool>& corner) {
  std::vector<std::uint32_t> count(mesh_.positions.size() + 1, 0);
  for (std::uint32_t e = 0; e < edges_.count(); ++e) {
    if (!edges_.isConvex(e)) continue;
    for (const std::uint32_t v : edges_.line(e).ends) count[v + 1] += corner[v] ? 1 : 0;
  }
  std::partial_sum(count.begin(), count.end(), count.begin());
  std::vector<std::uint32_t> at(count.begin(), count.end() - 1), list(count.back());
  for (std::uint32_t i = 0; i < edges_.count(); ++i) {
    if (!edges_.isConvex(i)) continue;
    for (const std::uint32_t v : edges_.line(i).ends) {
      if (corner[v]) list[at[v]++] = i;
    }
  }
  for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v) {
    if (!corner[v]) continue;
    const std::size_t first = out_.normals.size();
    for (std::uint32_t i = count[v]; i < count[v + 1]; ++i) {
      for (const glm::dvec3& normal : edges_.normals(list[i])) addDistinct(out_.normals, first, normal);
    }
    out_.samples.push_back({mesh_.positions[v], static_cast<std::uint32_t>(first),
                            static_cast<std::uint32_t>(out_.normals.size() - first), assets::kNone,
                            edges_.line(list[count[v]]).triangles[0], 0.0f});
  }
}

void MeshSampler::sampleSmooth(std::vector<bool>& sampled) {
  Thinning cells(mesh_.bounds.min, smoothSpacing_);
  const auto add = [&](std::uint32_t i, const glm::dvec3& p) {
    const auto normals = edges_.normals(i);
    const auto fresh = static_cast<std::uint32_t>(out_.samples.size()),
               at = cells.sampleAt(p, glm::normalize(normals[0] + normals[1]), fresh);
    if (at == fresh) {
      const auto first = static_cast<std::uint32_t>(out_.normals.size());
      out_.normals.insert(out_.normals.end(), normals.begin(), normals.end());
      out_.samples.push_back({p, first, 2, i, edges_.line(i).triangles[0], 0.0f});
    }
    // The surface goes on turning as it does in the cell up to the middle of the next one.
    ContactSample& sample = out_.samples[at];
    for (const glm::dvec3& normal : normals) {
      const double sine = glm::length(glm::cross(out_.normals[sample.firstNormal], normal));
      sample.turn = std::max(sample.turn, static_cast<float>(std::min(1.0, kBeyondCell * sine)));
    }
  };
  for (std::uint32_t i = 0; i < edges_.count(); ++i) {
    if (!edges_.isConvex(i) || sharpEdge_[i]) continue;
    const EdgeLine edge = edges_.line(i);
    for (int end = 0; end < 2; ++end) {
      const std::uint32_t v = edge.ends[static_cast<std::size_t>(end)];
      if (!sampled[v]) add(i, end == 0 ? edge.a : edge.b);
      sampled[v] = true;
    }
    const double length = glm::length(edge.b - edge.a);
    const int pieces = static_cast<int>(std::ceil(length / smoothSpacing_));
    for (int k = 1; k < pieces; ++k) add(i, edge.a + (edge.b - edge.a) * (static_cast<double>(k) / pieces));
  }
}

}  // namespace

SampleSet sampleMesh(const assets::Mesh& mesh, const MeshEdges& edges, double spacing, double smoothSpacing,
                     double sharp) {
  return MeshSampler(mesh, edges, spacing, smoothSpacing, sharp).sample();
}

}  // namespace tandem::haptics
