#include "haptics/scene/contact_samples.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_set>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/geometry/outward.h"

namespace tandem::haptics {
namespace {

/// A grid whose cells each hold at most one sample.
class Thinning {
 public:
  Thinning(const glm::dvec3& origin, double cell) : origin_(origin), cell_(cell) {}
  bool take(const glm::dvec3& p) {
    const glm::dvec3 q = glm::floor((p - origin_) / cell_);
    const auto part = [](double x) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(x)) & 0x1fffffu;
    };
    return taken_.insert(part(q.x) | part(q.y) << 21 | part(q.z) << 42).second;
  }

 private:
  glm::dvec3 origin_;
  double cell_;
  std::unordered_set<std::uint64_t> taken_;
};

void addDistinct(std::vector<glm::dvec3>& normals, std::size_t first, const glm::dvec3& normal) {
  for (std::size_t i = first; i < normals.size(); ++i) {
    if (glm::dot(normals[i], normal) > 1.0 - 1e-6) return;
  }
  normals.push_back(normal);
}

}  // namespace

double ContactSamples::usualSpacing(const assets::Mesh& mesh) {
  return glm::length(mesh.bounds.max - mesh.bounds.min) / 64.0;
}

ContactSamples::ContactSamples(const assets::Mesh& mesh, const MeshEdges& edges, const Options& options) {
  spacing_ = options.spacing > 0.0 ? options.spacing : usualSpacing(mesh);
  smoothSpacing_ = options.smoothSpacing > 0.0 ? options.smoothSpacing : 1.25 * spacing_;
  ASSERT(!(spacing_ < 0.0) && !(smoothSpacing_ < 0.0));

  std::vector<bool> taken(mesh.positions.size(), false);
  sampleSharpEdges(edges, options.sharp, taken);
  addCorners(mesh, edges, taken);
  sampleSmooth(mesh, edges, options.sharp, taken);
  finish();
}

void ContactSamples::finish() {
  if (samples_.empty()) return;
  std::vector<std::uint32_t> order(samples_.size());
  std::iota(order.begin(), order.end(), 0u);
  build(order, 0, static_cast<std::uint32_t>(order.size()));
  std::vector<ContactSample> sorted;
  sorted.reserve(samples_.size());
  for (const std::uint32_t i : order) sorted.push_back(samples_[i]);
  samples_ = std::move(sorted);
  points_.reserve(samples_.size());
  for (const ContactSample& sample : samples_) points_.emplace_back(glm::vec3(sample.point), sample.along);
}

/// Samples of the interior of sharp edges; marks the ends of those edges in `corner`.
void ContactSamples::sampleSharpEdges(const MeshEdges& edges, double sharp, std::vector<bool>& corner) {
  for (std::uint32_t i = 0; i < edges.edges().size(); ++i) {
    const MeshEdge& edge = edges.edges()[i];
    if (edge.angle < sharp) continue;
    corner[edge.ends[0]] = corner[edge.ends[1]] = true;
    const double length = glm::length(edge.b - edge.a);
    const int inner = std::max(1, static_cast<int>(std::ceil(length / spacing_)) - 1);
    const auto first = static_cast<std::uint32_t>(normals_.size());
    normals_.insert(normals_.end(), edge.normals.begin(), edge.normals.end());
    for (int k = 1; k <= inner; ++k) {
      samples_.push_back({edge.a + (edge.b - edge.a) * (static_cast<double>(k) / (inner + 1)), first, 2, i,
                          edge.triangles[0], roundUp(length / (inner + 1))});
    }
  }
}

/// One sample at each marked vertex, with the normals of all faces at its convex edges.
void ContactSamples::addCorners(const assets::Mesh& mesh, const MeshEdges& edges,
                                const std::vector<bool>& corner) {
  std::vector<std::uint32_t> count(mesh.positions.size() + 1, 0);
  for (const MeshEdge& edge : edges.edges()) {
    for (const std::uint32_t v : edge.ends) count[v + 1] += corner[v] && edge.angle > 0.0 ? 1 : 0;
  }
  std::partial_sum(count.begin(), count.end(), count.begin());
  std::vector<std::uint32_t> at(count.begin(), count.end() - 1), list(count.back());
  for (std::uint32_t i = 0; i < edges.edges().size(); ++i) {
    const MeshEdge& edge = edges.edges()[i];
    for (const std::uint32_t v : edge.ends) {
      if (corner[v] && edge.angle > 0.0) list[at[v]++] = i;
    }
  }
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (!corner[v]) continue;
    const std::size_t first = normals_.size();
    for (std::uint32_t i = count[v]; i < count[v + 1]; ++i) {
      for (const glm::dvec3& normal : edges.edges()[list[i]].normals) addDistinct(normals_, first, normal);
    }
    samples_.push_back({mesh.positions[v], static_cast<std::uint32_t>(first),
                        static_cast<std::uint32_t>(normals_.size() - first), assets::kNone,
                        edges.edges()[list[count[v]]].triangles[0], 0.0f});
  }
}

/// Samples of the edges of smooth convex surfaces, one per cell of a grid.
void ContactSamples::sampleSmooth(const assets::Mesh& mesh, const MeshEdges& edges, double sharp,
                                  std::vector<bool>& taken) {
  Thinning cells(mesh.bounds.min, smoothSpacing_);
  const auto add = [&](const MeshEdge& edge, const glm::dvec3& p) {
    if (!cells.take(p)) return;
    const auto first = static_cast<std::uint32_t>(normals_.size());
    normals_.insert(normals_.end(), edge.normals.begin(), edge.normals.end());
    samples_.push_back({p, first, 2, assets::kNone, edge.triangles[0], 0.0f});
  };
  for (const MeshEdge& edge : edges.edges()) {
    if (edge.angle >= sharp || edge.angle <= 0.0) continue;
    for (int end = 0; end < 2; ++end) {
      const std::uint32_t v = edge.ends[static_cast<std::size_t>(end)];
      if (!taken[v]) add(edge, end == 0 ? edge.a : edge.b);
      taken[v] = true;
    }
    const double length = glm::length(edge.b - edge.a);
    const int pieces = static_cast<int>(std::ceil(length / smoothSpacing_));
    for (int k = 1; k < pieces; ++k)
      add(edge, edge.a + (edge.b - edge.a) * (static_cast<double>(k) / pieces));
  }
}

std::uint32_t ContactSamples::build(std::vector<std::uint32_t>& order, std::uint32_t begin,
                                    std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  glm::dvec3 low(1e300), high(-1e300);
  for (std::uint32_t i = begin; i < end; ++i) {
    low = glm::min(low, samples_[order[i]].point);
    high = glm::max(high, samples_[order[i]].point);
  }
  const glm::dvec3 centre = 0.5 * (low + high), extent = high - low;
  Node node{{static_cast<float>(centre.x), static_cast<float>(centre.y), static_cast<float>(centre.z)},
            0.0f,
            begin,
            end,
            0};
  const glm::dvec3 rounded(node.centre[0], node.centre[1], node.centre[2]);
  double radius = 0.0;
  for (std::uint32_t i = begin; i < end; ++i) {
    const ContactSample& sample = samples_[order[i]];
    radius = std::max(radius, glm::length(sample.point - rounded) + static_cast<double>(sample.along));
  }
  node.radius = roundUp(radius);
  if (end - begin > kMostInLeaf) {
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                     [&](std::uint32_t i, std::uint32_t j) {
                       const double a = samples_[i].point[axis], b = samples_[j].point[axis];
                       return a != b ? a < b : i < j;
                     });
    build(order, begin, middle);
    node.second = build(order, middle, end);
  }
  nodes_[index] = node;
  return index;
}

std::size_t ContactSamples::memory() const {
  return samples_.size() * (sizeof(ContactSample) + sizeof(glm::vec4)) +
         normals_.size() * sizeof(glm::dvec3) + nodes_.size() * sizeof(Node) +
         patches_.size() * sizeof(ContactPatch);
}

}  // namespace tandem::haptics
