#pragma once

// What two people do with a part that both hold, and what is measured of it.

#include "haptics/link_bench/link_bench.h"

namespace tandem::bench {

/// What every run must keep within.
struct Tally {
  bool astray = false;
  double created = 0.0;     // J, at the device ports
  double inLinks = 0.0;     // J
  double change = 0.0;      // N in 20 ms, on any hand, while the run says so
  double turnChange = 0.0;  // N m in 20 ms

  void take(const HandBench& bench);
  void worst(const Tally& other);
};

inline constexpr double kEnergyBound = 1e-3;  // J

/// Grips at the centre of mass, or off it on different sides.
std::vector<BenchSite> twoHands(const haptics::ArmParameters& first, const haptics::ArmParameters& second,
                                bool offCentre = false);

/// The shared drag: 5 cm at 0.5 Hz from 1 s on.
haptics::SixAxes dragWay(double t, double amplitude = 0.05);

struct DragFigures : Tally {
  double rms = 0.0, most = 0.0;  // m, between the replicas
  double turnRms = 0.0;          // rad
  double load = 0.0;             // N rms on the leader
  double offGrip = 0.0;          // m rms: of the leader's device from where the part that it sees is held
};
struct DragPlan {
  double amplitude = 0.05;      // m
  double turn = 0.0;            // rad, about a slanted axis, in step with the way
  double from = 4.0, to = 7.0;  // s, in which changes of force count
  double until = 10.5;          // s; the rest is measured from 3 to 8 s
};
/// Site 0 moves the part to and fro at 0.5 Hz, the others hold on.
DragFigures drag(HandBench& bench, const DragPlan& plan = {});
DragFigures drag(const BenchSetup& setup, const DragPlan& plan = {});

struct PullFigures : Tally {
  double stiffness = 0.0;  // N/m, from hand to hand
  double rest = 0.0;       // m, peak to peak in the last 1.5 s
  double restless = 0.0;   // N in 20 ms, then
};
enum class LetGo { nobody, second, both };
inline constexpr double kLetGo = 6.0;  // s
/// The second site pulls 15 mm away from the first; at kLetGo somebody lets go. The stiffness is measured before.
PullFigures pull(HandBench& bench, LetGo who, double until = 12.0);
PullFigures pull(const BenchSetup& setup, LetGo who);

struct PressFigures : Tally {
  double stiffness = 0.0;  // N/m, that the second site feels: least squares from where the part touches
};
/// The block of these people stands 5 mm before a wall.
Block beforeWall(Block block);
/// The second site, whose arm is `arm`, presses the part with 2 N against that wall, the first one holds on.
PressFigures press(HandBench& bench, const haptics::ArmParameters& arm);
PressFigures press(const BenchSetup& setup);

}  // namespace tandem::bench
