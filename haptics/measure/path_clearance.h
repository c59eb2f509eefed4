#pragma once

// How far a path stays from the parts of a scene, asked of every triangle: a ball of that radius can go the
// same way in one continuous motion. It shares nothing with the tool's contact, which it judges.

#include <array>
#include <cstdint>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// The parts of a scene at rest. Keeps a reference to the scene.
class PathClearance {
 public:
  explicit PathClearance(const assets::Scene& scene);

  /// Whether a ball can go straight from p to q, world. Its radius is `share` of the largest coordinate of
  /// each part's mesh.
  bool ballPasses(const glm::dvec3& p, const glm::dvec3& q, double share) const;

 private:
  bool passes(std::uint32_t mesh, const glm::dvec3& p, const glm::dvec3& q, double share) const;

  const assets::Scene& scene_;
  std::vector<std::vector<assets::Bounds>> boxes_;  // of the triangles of each mesh
};

}  // namespace tandem::haptics
