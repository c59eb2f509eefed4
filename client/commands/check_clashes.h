#pragma once

// `tandem check --clash` and `--distance`: overlaps, touches and distances of parts.

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/base/json.h"
#include "assets/scene/scene.h"
#include "client/review/clash_check.h"

namespace tandem::client {

struct ClashArguments {
  bool all = false;                   // --clash
  double clearance = 0.0;             // --clearance, m
  double tolerance = 0.0;             // --tolerance, m
  std::vector<std::string> distance;  // --distance: two names, or none
  bool json = false;

  bool requested() const { return all || !distance.empty(); }
};

/// A point or a direction as --json has it: its three coordinates.
Json pointJson(const glm::dvec3& p);
/// One pair as --json has it, and as text.
Json clashJson(const assets::Scene& scene, const Clash& clash);
void printClash(const assets::Scene& scene, const Clash& clash);

/// Prints the clashes and the distance that the arguments request; returns the exit code.
int runClashes(const assets::Scene& scene, const ClashArguments& arguments);

}  // namespace tandem::client
