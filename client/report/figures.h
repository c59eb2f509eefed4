#pragma once

// Figures that no plot of cost against error shows: friction of a curved mesh, refitting a tree, the closed
// loop of a device and a wall. Measured in this process in a few seconds.

#include <string>
#include <vector>

namespace tandem::client::report {

struct Figure {
  std::string id;    // kebab-case
  std::string name;  // for people
  std::string unit;  // empty: a ratio
  double value = 0.0;
  double target = 0.0;   // 0: none
  bool atLeast = false;  // the target is a lower bound
};

/// `quick` leaves out what takes seconds.
std::vector<Figure> measureFigures(bool quick);

}  // namespace tandem::client::report
