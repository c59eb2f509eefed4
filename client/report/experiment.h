#pragma once

// The experiments of the report: a scene, a device path a tick long each row, and where an ideal god object
// is in every tick. The same experiments are given to Tandem, to the baselines and to the peers.

#include <string>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::client::report {

/// What sets an experiment apart from the others of its family.
struct ExperimentInfo {
  std::string id;           // kebab-case, as --scenes takes it
  std::string family;       // experiments of one family share a plot
  std::string title;        // for people
  std::string about;        // one sentence: what moves where
  bool quick = false;       // part of --quick
  double toolRadius = 0.0;  // m
  double friction = 0.0;    // static and dynamic; baselines and peers have none and are left out
};

/// One tick of the path.
struct PathPoint {
  glm::dvec3 device{0.0, 0.0, 0.0};      // m, world
  glm::dvec3 exactProxy{0.0, 0.0, 0.0};  // m, world: of an ideal god object
  double lift = 0.0;                     // m: by how much every part stands above where the scene has it
};

/// A scene made ready for one experiment. Built in the code, the same on every machine.
struct Experiment {
  ExperimentInfo info;
  assets::Scene scene;
  std::vector<PathPoint> path;  // one entry a millisecond; starts in free space
  bool partsMove = false;       // all parts follow PathPoint::lift
  double stiffness = 1000.0;    // N/m
  double facetDepth = 0.0;      // m: the most by which facets lie under the exact surface; 0 = they are exact
  double facetTilt = 0.0;       // rad: the most by which a facet's normal is off
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
