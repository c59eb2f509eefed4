#pragma once

// `tandem check --clash` and `--distance`: how parts stand to each other.

#include <string>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::client {

struct ClashArguments {
  bool all = false;                   // --clash
  double clearance = 0.0;             // --clearance, m
  double tolerance = 0.0;             // --tolerance, m
  std::vector<std::string> distance;  // --distance: two names, or none
  bool json = false;

  bool asked() const { return all || !distance.empty(); }
};

/// Prints what was asked; returns the exit code.
int runClashes(const assets::Scene& scene, const ClashArguments& arguments);

}  // namespace tandem::client
