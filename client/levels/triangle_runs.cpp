#include "client/levels/triangle_runs.h"

#include <algorithm>
#include <limits>

#include <glm/geometric.hpp>

namespace tandem::client {
namespace {

constexpr std::uint32_t kRun = 256;  // triangles

}  // namespace

TriangleRuns::TriangleRuns(const assets::Mesh& mesh) : mesh_(mesh), order_(drawingOrder(mesh)) {
  const auto count = static_cast<std::uint32_t>(order_.size());
  for (std::uint32_t first = 0; first < count; first += kRun) {
    RenderCluster run{first, std::min(kRun, count - first), {}, 0.0f};
    glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
    for (std::uint32_t i = first; i < first + run.indexCount; ++i)
      for (const std::uint32_t vertex : mesh.triangles[order_[i]]) {
        low = glm::min(low, glm::vec3(mesh.positions[vertex]));
        high = glm::max(high, glm::vec3(mesh.positions[vertex]));
      }
    run.centre = 0.5f * (low + high);
    run.radius = 0.5f * glm::length(high - low);
    runs_.push_back(run);
  }
}

}  // namespace tandem::client
