#pragma once

// What two people do with a part that a link ties together, and what is measured of it.

#include <cstdio>
#include <functional>

#include "tests/haptics/link/link_bench.h"

namespace tandem::test {

/// What every run must keep within.
struct Tally {
  bool astray = false;
  double created = 0.0;     // J, at the device ports
  double inLinks = 0.0;     // J
  double change = 0.0;      // N in 20 ms, on any hand, while the run says so
  double turnChange = 0.0;  // N m in 20 ms

  void take(const LinkBench& bench);
  void worst(const Tally& other);
};

inline constexpr double kEnergyBound = 1e-3;  // J
void expectPassive(const Tally& tally, const char* what);

/// Grips at the centre of mass, or off it on different sides.
std::vector<BenchSite> twoHands(const haptics::ArmParameters& first, const haptics::ArmParameters& second,
                                bool offCentre = false);

struct DragFigures : Tally {
  double rms = 0.0, most = 0.0;  // m, between the replicas
  double turnRms = 0.0;          // rad
  double load = 0.0;             // N rms on the leader
};
struct DragPlan {
  double amplitude = 0.05;      // m
  double turn = 0.0;            // rad, about a slanted axis, in step with the way
  double from = 4.0, to = 7.0;  // s, in which changes of force count
  double until = 10.5;          // s
};
/// Site 0 moves the part to and fro at 0.5 Hz, the other one holds on. Sites are those of the setup.
DragFigures drag(const BenchSetup& setup, const DragPlan& plan = {});

struct PullFigures : Tally {
  double stiffness = 0.0;  // N/m, from hand to hand
  double rest = 0.0;       // m, peak to peak in the last 1.5 s
  double restless = 0.0;   // N in 20 ms, then
};
enum class LetGo { nobody, second, both };
/// The second site pulls 15 mm away from the first; at 6 s somebody lets go.
PullFigures pull(const BenchSetup& setup, LetGo who);

struct PressFigures : Tally {
  double stiffness = 0.0;  // N/m, that the second site feels: least squares from where the part touches
};
/// The second site presses the part with 2 N against a wall that stands 5 mm away, the first one holds on.
PressFigures press(const BenchSetup& setup);

}  // namespace tandem::test
