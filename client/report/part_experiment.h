#pragma once

// The report's experiments with a part in the hand: two parts, a path of the hand, and the force of an ideal
// god object in every tick. Tandem and the peers run the same experiments. Lengths in m, world frame.

#include <string>
#include <vector>

#include "client/report/experiment.h"

namespace tandem::client::report {

inline constexpr PartId kHeldPart = 0, kOtherPart = 1;  // of every scene here

/// One tick of the path, and the figures that can be judged in it.
struct PartPathPoint {
  glm::dvec3 goal{0.0, 0.0, 0.0};         // the target of the held part's origin
  glm::dquat turned{1.0, 0.0, 0.0, 0.0};  // by how much it is to be turned since the path began
  glm::dvec3 exactForce{0.0, 0.0,
                        0.0};  // N, on the hand, of an ideal part that follows the hand in steady state
  bool contact = false;        // the parts touch, or would if nothing had stopped the held one
  bool force = false;          // the exact force holds
  bool depth = false;          // the held part must not be in the other one
};

/// One experiment with its scene, which is generated and the same on every machine.
struct PartExperiment {
  ExperimentInfo info;
  assets::Scene scene;              // kHeldPart where the path begins; kOtherPart stands still at the origin
  glm::dvec3 grip{0.0};             // the hand's grip, in the held part's frame
  std::vector<PartPathPoint> path;  // one entry a millisecond
  double stiffness = 1000.0;        // N/m, of the coupling
  double damping = 4.0;             // N·s/m
  double targetDepth = 5e-6;        // m, the project's target for the penetration
};

/// All of them, in the order of the report.
std::vector<ExperimentInfo> allPartExperiments();

/// Builds one by its id, with about `ticks` ticks; `quick`: of fewer triangles where that saves seconds. The
/// id must be one of allPartExperiments().
PartExperiment buildPartExperiment(const std::string& id, int ticks, bool quick = false);

/// Puts the parts into the scene, without friction; the held one where the path begins, lying as `turned`
/// says.
void addParts(PartExperiment& e, assets::Mesh held, assets::Mesh other,
              const glm::dquat& turned = {1.0, 0.0, 0.0, 0.0},
              const glm::dquat& otherTurned = {1.0, 0.0, 0.0, 0.0});

/// The point nearest to `goal` in a regular polygon around the origin with `sides` sides at a distance of
/// `inner` m; a corner lies on +x.
glm::dvec2 insidePolygon(const glm::dvec2& goal, double inner, int sides);

}  // namespace tandem::client::report
