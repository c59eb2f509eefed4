#pragma once

// The figures of one method in one experiment, and how they are judged.

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "client/report/experiment.h"

namespace tandem::client::report {

/// Microseconds a tick. A tick gives the same bits every time, so each tick's cost is the least of several
/// runs, which leaves out the time that other programs took. `p99Single` is the 99th percentile of the first
/// run alone.
struct Cost {
  double p50 = 0.0, p99 = 0.0, max = 0.0, p99Single = 0.0;
};
/// `least` of several runs and `single` of the first one, a tick each, us. Neither may be empty.
Cost costOf(const std::vector<double>& least, const std::vector<double>& single);

/// Distance of the force from the exact one.
struct ForceError {
  double rms = 0.0, p99 = 0.0, max = 0.0;                          // N
  double relativeRms = 0.0, relativeP99 = 0.0, relativeMax = 0.0;  // share of the exact force of that tick
};

/// The largest change of force from one tick to the next, N.
struct ForceStep {
  double measured = 0.0, ideal = 0.0;
  double excess = 0.0;        // largest difference between the two changes of one tick
  double beyondTravel = 0.0;  // most by which a change was more than the stiffness times the hand's travel
  std::uint64_t jumps = 0;    // ticks in which that was more than kFeltJump
};
inline constexpr double kFeltJump = 0.05;  // N

enum class Kind { tandem, baseline, peer };

/// One point of a plot.
struct Measurement {
  std::string setting;  // stable id: "tandem", "one-plane", "embree", ...
  std::string name;     // for people
  Kind kind = Kind::tandem;
  Cost cost;
  Cost hovering;  // of the ticks in free space after the first contact; 0 where there are none
  ForceError error;
  ForceStep step;
  double beyondDepth = 0.0;       // N: most by which a force was more than the stiffness times its own depth
  std::uint64_t allocations = 0;  // in all ticks
  bool allocationsCounted = false;
  double build_ms = 0.0;  // of the tree, or the method's equivalent
};

/// One run of a method over a path.
struct Samples {
  std::vector<double> us;         // one a tick
  std::vector<glm::dvec3> force;  // one a tick, N
  std::vector<double> depth;      // one a tick, m: from the device to the method's proxy; empty: not known
};

/// Root mean square; 0 of none.
double rms(const std::vector<double>& values);

/// Computes the figures from the forces of the first run and the least cost of all runs. Every run must have
/// path.size() entries.
void judge(const Experiment& experiment, const std::vector<Samples>& runs, Measurement& out);

}  // namespace tandem::client::report
