#pragma once

// The triangles of a mesh in runs of neighbours, so that those near a ray are found without a copy of all.

#include <cstdint>
#include <vector>

#include "client/levels/render_mesh.h"

namespace tandem::client {

class TriangleRuns {
 public:
  /// `mesh` outlives this. O(T log T).
  explicit TriangleRuns(const assets::Mesh& mesh);

  /// Appends the corners, m, part frame, of all triangles in runs for whose spheres (centre, radius; part
  /// frame) the test holds.
  template <typename Test>
  void gather(Test&& test, std::vector<glm::vec3>& corners) const {
    for (const RenderCluster& run : runs_) {
      if (!test(run)) continue;
      for (std::uint32_t i = run.firstIndex; i < run.firstIndex + run.indexCount; ++i)
        for (const std::uint32_t vertex : mesh_.triangles[order_[i]])
          corners.emplace_back(mesh_.positions[vertex]);
    }
  }

 private:
  const assets::Mesh& mesh_;
  std::vector<std::uint32_t> order_;  // triangles
  std::vector<RenderCluster> runs_;   // into order_
};

}  // namespace tandem::client
