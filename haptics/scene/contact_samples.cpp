#include "haptics/scene/contact_samples.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/geometry/outward.h"
#include "haptics/scene/mesh_samples.h"
#include "haptics/scene/primitive_samples.h"

namespace tandem::haptics {

double ContactSamples::usualSpacing(const assets::Mesh& mesh) {
  return glm::length(mesh.bounds.max - mesh.bounds.min) / 64.0;
}

ContactSamples::ContactSamples(const Options& options, const assets::Mesh& mesh) {
  spacing_ = options.spacing > 0.0 ? options.spacing : usualSpacing(mesh);
  smoothSpacing_ = options.smoothSpacing > 0.0 ? options.smoothSpacing : 1.25 * spacing_;
  ASSERT(!(spacing_ < 0.0) && !(smoothSpacing_ < 0.0));
  sagOfTurn_ = roundUp(kSag * smoothSpacing_);
}

ContactSamples::ContactSamples(const assets::Mesh& mesh, const MeshEdges& edges, const Options& options)
    : ContactSamples(options, mesh) {
  set_ = sampleMesh(mesh, edges, spacing_, smoothSpacing_, options.sharp);
  sort();
  axes_.reserve(set_.samples.size());
  for (const ContactSample& sample : set_.samples) {
    if (sample.edge == assets::kNone || isSmooth(sample)) {
      axes_.emplace_back(0.0f);
    } else {
      const EdgeLine edge = edges.line(sample.edge);
      axes_.emplace_back(glm::normalize(edge.b - edge.a));
    }
  }
}

ContactSamples::ContactSamples(std::span<const assets::ImplicitShape> shapes, const assets::Mesh& mesh,
                               const Options& options)
    : ContactSamples(options, mesh) {
  set_ = sampleShapes(shapes, mesh, spacing_);
  sort();
  axes_.reserve(set_.samples.size());
  for (const ContactSample& sample : set_.samples)
    axes_.emplace_back(sample.patch == assets::kNone || isRound(sample) ? glm::dvec3(0.0)
                                                                        : set_.patches[sample.patch].axis);
}

void ContactSamples::sort() {
  if (set_.samples.empty()) return;
  std::vector<std::uint32_t> order(set_.samples.size());
  std::iota(order.begin(), order.end(), 0u);
  build(order, 0, static_cast<std::uint32_t>(order.size()));
  std::vector<ContactSample> sorted;
  sorted.reserve(set_.samples.size());
  for (const std::uint32_t i : order) sorted.push_back(set_.samples[i]);
  set_.samples = std::move(sorted);
  set_.normals.shrink_to_fit();
  points_.reserve(set_.samples.size());
  for (const ContactSample& sample : set_.samples)
    points_.emplace_back(glm::vec3(sample.point), isSmooth(sample) ? -sag(sample) : sample.along);
}

std::uint32_t ContactSamples::build(std::vector<std::uint32_t>& order, std::uint32_t begin,
                                    std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  glm::dvec3 low(1e300), high(-1e300);
  for (std::uint32_t i = begin; i < end; ++i) {
    low = glm::min(low, set_.samples[order[i]].point);
    high = glm::max(high, set_.samples[order[i]].point);
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
    const ContactSample& sample = set_.samples[order[i]];
    const float about = isSmooth(sample) ? sag(sample) : sample.along;
    radius = std::max(radius, glm::length(sample.point - rounded) + static_cast<double>(about));
  }
  node.radius = roundUp(radius);
  if (end - begin > kMaxInLeaf) {
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                     [&](std::uint32_t i, std::uint32_t j) {
                       const double a = set_.samples[i].point[axis], b = set_.samples[j].point[axis];
                       return a != b ? a < b : i < j;
                     });
    build(order, begin, middle);
    node.second = build(order, middle, end);
  }
  nodes_[index] = node;
  return index;
}

std::size_t ContactSamples::memory() const {
  return set_.samples.size() * (sizeof(ContactSample) + sizeof(glm::vec4) + sizeof(glm::vec3)) +
         set_.normals.size() * sizeof(glm::dvec3) + nodes_.size() * sizeof(Node) +
         set_.patches.size() * sizeof(ContactPatch);
}

}  // namespace tandem::haptics
