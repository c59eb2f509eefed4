#pragma once

// `tandem check --measure`: what is at one or two places of a scene, and between them.
//
// --json: {"places": [{"part", "point_m", "normal", "edge": null | {"length_m", "segments", "start_m",
// "end_m"}, "cylinder": null | {"diameter_m", "hollow", "length_m", "middle_m", "axis"}}]}; of two places
// also "between": {"distance_m", "angle_deg", "across_m": null where not parallel} and "parts": what
// --distance says of their parts, null if both are on one.

#include <string>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::client {

struct MeasureArguments {
  std::vector<std::string> places;  // --measure: "X,Y,Z", m, world; one or two, or none
  bool json = false;

  bool requested() const { return !places.empty(); }
};

/// Prints the measures that the arguments request; returns the exit code.
int runMeasure(const assets::Scene& scene, const MeasureArguments& arguments);

}  // namespace tandem::client
