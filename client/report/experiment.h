#pragma once

// The experiments of the report: a scene, a device path with an entry a tick, and the position of an ideal
// god object in every tick. Tandem, the baselines and the peers run the same experiments.

#include <string>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::client::report {

inline constexpr double kDt = 1e-3;          // s, of a tick of any experiment
inline constexpr double kMillimetre = 1e-3;  // m

/// The description of an experiment.
struct ExperimentInfo {
  std::string id;           // kebab-case, as --scenes takes it
  std::string family;       // experiments of one family share a plot
  std::string title;        // for people
  std::string about;        // one sentence: the motion and the surface
  bool quick = false;       // part of --quick
  double toolRadius = 0.0;  // m
  double friction = 0.0;    // static and dynamic; baselines and peers have none and are left out
  bool exact = true;        // false: the answer is that of a body of which the mesh is a rough scan
};

/// One tick of the path.
struct PathPoint {
  glm::dvec3 device{0.0, 0.0, 0.0};      // m, world
  glm::dvec3 exactProxy{0.0, 0.0, 0.0};  // m, world: of an ideal god object; in free space the device
  double lift = 0.0;                     // m: by how much every part stands above where the scene has it
};

/// One experiment with its scene, which is generated and the same on every machine.
struct Experiment {
  ExperimentInfo info;
  assets::Scene scene;
  std::vector<PathPoint> path;  // one entry a millisecond; starts in free space
  bool partsMove = false;       // all parts follow PathPoint::lift
  bool curved = false;          // stands for a smooth body, so that shading its facets makes sense
  double stiffness = 1000.0;    // N/m
  double facetDepth = 0.0;  // m: the largest depth of a facet under the exact surface; 0 = the mesh is exact
  double facetTilt = 0.0;   // rad: the largest error of a facet's normal
};

/// All experiments, in the order of the report.
std::vector<ExperimentInfo> allExperiments();

/// Builds one by its id, with about `ticks` ticks. The id must be one of allExperiments().
Experiment buildExperiment(const std::string& id, int ticks);

/// Force of a spring from the device to its proxy, N, on the hand.
inline glm::dvec3 springForce(double stiffness, const glm::dvec3& proxy, const glm::dvec3& device) {
  return stiffness * (proxy - device);
}

}  // namespace tandem::client::report
