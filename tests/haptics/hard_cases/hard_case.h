#pragma once

// Hard cases run at three scales. A case is written once, in lengths of about a hand; the probe multiplies
// lengths on the way in and divides forces on the way out, so that at every scale the same figures must come
// back.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "haptics/tick_data.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::test {

inline constexpr double kScales[] = {1.0, 1e-3, 20.0};
inline constexpr double kStiffness = 800.0;  // N/m, of springOnly()

inline assets::Mesh scaledMesh(assets::Mesh mesh, double scale) {
  for (glm::dvec3& p : mesh.positions) p *= scale;
  mesh.bounds.min *= scale;
  mesh.bounds.max *= scale;
  return mesh;
}

/// A mesh of bare triangles, as they come: nothing is welded, sorted out or oriented.
inline assets::Mesh soupMesh(const std::vector<glm::dvec3>& positions,
                             const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  assets::Mesh mesh;
  mesh.positions = positions;
  mesh.triangles = triangles;
  mesh.triangleMaterial.assign(triangles.size(), 0);
  for (const glm::dvec3& p : positions) {
    mesh.bounds.include(p);
  }
  return mesh;
}

inline assets::Scene sceneOf(assets::Mesh mesh) {
  SceneBuilder b;
  b.addPart(std::move(mesh));
  return b.scene;
}

/// A hand in a scaled scene; the caller thinks in unscaled lengths.
class ScaledHand {
 public:
  ScaledHand(assets::Scene scene, double by, double radius = 0.0)
      : scale(by), probe(scaled(std::move(scene), by)) {
    probe.parameters.toolRadius = radius * by;
  }

  /// Force of that tick, N, as of the unscaled scene.
  glm::dvec3 at(const glm::dvec3& position) {
    probe.at(scale * position);
    return force();
  }
  glm::dvec3 to(const glm::dvec3& target, double step) {
    probe.to(scale * target, scale * step);
    return force();
  }
  glm::dvec3 force() const { return probe.out.hands[0].toHand.force / scale; }
  glm::dvec3 proxy() const { return probe.out.worldFromProxy.position / scale; }
  /// Distance that the proxy keeps from a part, unscaled: what an exact answer may differ by.
  double skin(PartId part = 0) {
    return probe.state.data().world.skin(part, probe.out.worldFromProxy.position) / scale;
  }

  double scale;
  HandProbe probe;

 private:
  static assets::Scene scaled(assets::Scene scene, double scale) {
    for (assets::Mesh& mesh : scene.meshes) mesh = scaledMesh(std::move(mesh), scale);
    for (assets::Part& part : scene.parts) part.worldFromPart.position *= scale;
    return scene;
  }
};

/// Runs a case at every scale. `run(scale, forces)` appends what was felt; the lists must agree within
/// `tolerance` N.
template <typename Run>
void atEveryScale(double tolerance, const Run& run) {
  std::vector<glm::dvec3> first;
  for (const double scale : kScales) {
    SCOPED_TRACE("scale " + std::to_string(scale));
    std::vector<glm::dvec3> forces;
    run(scale, forces);
    ASSERT_FALSE(forces.empty());
    if (first.empty()) first = forces;
    ASSERT_EQ(forces.size(), first.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < forces.size(); ++i)
      worst = std::max(worst, glm::length(forces[i] - first[i]));
    EXPECT_LE(worst, tolerance) << "force depends on the scale";
    if (testing::Test::HasFatalFailure()) return;
  }
}

}  // namespace tandem::test
