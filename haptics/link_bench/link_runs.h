#pragma once

// Test runs of two people with a part that both hold, and what they measure.

#include "haptics/link_bench/link_bench.h"

namespace tandem::bench {

/// Bounds on every run.
struct Tally {
  bool astray = false;
  double created = 0.0;     // J, at the device ports
  double inLinks = 0.0;     // J
  double change = 0.0;      // N in 20 ms, on any hand, while the run says so
  double turnChange = 0.0;  // N·m in 20 ms

  void note(const HandBench& bench);
  void worst(const Tally& other);
};

inline constexpr double kEnergyBound = 1e-3;  // J

/// Grips at the centre of mass, or off it on different sides.
std::vector<BenchSite> twoHands(const haptics::ArmParameters& first, const haptics::ArmParameters& second,
                                bool offCentre = false);

/// The shared drag: 5 cm at 0.5 Hz from 1 s on.
haptics::SixAxes dragPath(double t, double amplitude = 0.05);

struct DragFigures : Tally {
  double rms = 0.0, most = 0.0;  // m, between the replicas
  double turnRms = 0.0;          // rad
  double load = 0.0;             // N rms on the leader
  double offGrip = 0.0;  // m rms: distance of the leader's device from its grip on the locally seen part
};
struct DragPlan {
  double amplitude = 0.05;      // m
  double turn = 0.0;            // rad, about a slanted axis, in phase with the displacement
  double from = 4.0, to = 7.0;  // s, in which changes of force count
  double until = 10.5;          // s; the rest is measured from 3 to 8 s
};
/// Site 0 drags the part to and fro at 0.5 Hz while the others hold it.
DragFigures drag(HandBench& bench, const DragPlan& plan = {});
DragFigures drag(const BenchSetup& setup, const DragPlan& plan = {});

struct PullFigures : Tally {
  double stiffness = 0.0;  // N/m, between the hands
  double rest = 0.0;       // m, peak to peak in the last 1.5 s
  double restless = 0.0;   // N in 20 ms, during that time
};
enum class LetGo { nobody, second, both };
inline constexpr double kLetGo = 6.0;  // s
/// The second site pulls 15 mm away from the first; at kLetGo one lets go. The stiffness is measured before
/// that.
PullFigures pull(HandBench& bench, LetGo who, double until = 12.0);
PullFigures pull(const BenchSetup& setup, LetGo who);

struct PressFigures : Tally {
  double stiffness = 0.0;  // N/m, felt by the second site: least squares from the first contact on
};
/// The block of these people stands 5 mm before a wall.
Block beforeWall(Block block);
/// The second site, whose arm is `arm`, presses the part with 2 N against that wall while the first holds it.
PressFigures press(HandBench& bench, const haptics::ArmParameters& arm);
PressFigures press(const BenchSetup& setup);

}  // namespace tandem::bench
