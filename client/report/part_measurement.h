#pragma once

// The figures of one method in one experiment with a part in the hand, and how they are judged.

#include <cstdint>
#include <string>
#include <vector>

#include "client/report/manifold.h"
#include "client/report/measurement.h"
#include "client/report/part_experiment.h"
#include "haptics/base/contact_effort.h"

namespace tandem::client::report {

/// A value over the judged ticks.
struct Spread {
  double p50 = 0.0, p99 = 0.0, max = 0.0;
};

/// One point of a plot.
struct PartMeasurement {
  std::string setting;  // stable id: "tandem", "field-4-samples-2", "fcl", ...
  std::string name;     // for people
  Kind kind = Kind::tandem;
  double fieldScale = 1.0, sampleScale = 1.0;  // haptics::ModelOptions; 1 for peers
  haptics::ContactEffort effort;               // of the tick; the default for peers
  Cost cost;                                   // of a whole tick; peers: of their query alone
  Spread depth;        // m, exact penetration; peers: error of the depth that they report
  ForceError error;    // N
  Spread forceStep;    // N a tick, beyond the exact change
  Spread forceChange;  // N a tick, in all
  Spread normalStep;   // rad a tick, of the contact's direction
  double found = 0.0;  // share of the ticks with a contact in which one with the right sense was reported
  double cell = 0.0,
         spacing =
             0.0;  // m, of the held part: smallest cell of its field, spacing of its samples; 0 for peers
  double build_ms = 0.0;
  std::size_t memory = 0;         // bytes, of what was built; 0: not known
  std::uint64_t allocations = 0;  // in all ticks
  bool allocationsCounted = false;
  std::vector<ManifoldBin> active,
      solved;  // cost by rows that push at the end of a tick; by rows solved in it
};

/// Whether the tick has as many steps and queries as in use.
bool usualIterations(const haptics::ContactEffort& effort);

/// One tick of one run.
struct PartSample {
  double us = 0.0;                   // below 0: the tick was left out
  glm::dvec3 force{0.0, 0.0, 0.0};   // N, on the hand
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit, away from the other part; 0: no contact was reported
  double depth = -1.0;               // m, as PartMeasurement::depth; below 0: not measured in this tick
  int active = 0, solved = 0;        // rows of the contact; 0 of peers
};

/// Judges the first run, and the least cost of all. Every run must have path.size() entries.
void judgePart(const PartExperiment& experiment, const std::vector<std::vector<PartSample>>& runs,
               PartMeasurement& out);

}  // namespace tandem::client::report
