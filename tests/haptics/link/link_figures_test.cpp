// What a link carries at each delay: stiffness of walls and from hand to hand, how far replicas are apart,
// the leader's load. Bounds are those of the project's table; the figures are printed with TANDEM_FULL_SIZE.

#include <gtest/gtest.h>

#include "tests/haptics/link/link_checks.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

struct Row {
  double delay;      // s
  double stiffness;  // N/m, from hand to hand, at least
  double rms;        // m, in the shared drag, at most
  double load;       // times that without a delay, at most
};
constexpr double kOff = -1.0;
constexpr Row kRows[] = {{0.010, 270.0, 1.2e-3, 1.1},
                         {0.025, 217.0, 2.0e-3, 1.2},
                         {0.050, 164.0, 3.7e-3, 1.4},
                         {0.100, 66.0, 10.0e-3, 1.5},
                         {0.250, kOff, kOff, 1.0}};
constexpr double kLoadWithoutDelay = 1.02;  // N rms: of the leader of the shared drag

BenchSetup benchAt(double delay, int seed) {
  BenchSetup setup;
  setup.network.delay = delay;
  setup.seed = static_cast<unsigned>(seed);
  return setup;
}

TEST(LinkFigures, DragStaysTogetherAndTheLeaderIsNotLoaded) {
  for (const Row& row : kRows) {
    for (const bool offCentre : {false, true}) {
      DragFigures worst;
      for (int seed = 1; seed <= seeds(); ++seed) {
        BenchSetup setup = benchAt(row.delay, seed);
        setup.sites = twoHands(firmArm(), lightArm(), offCentre);
        const DragFigures d = drag(setup);
        expectPassive(d, "drag");
        worst.worst(d);
        worst.rms = std::max(worst.rms, d.rms), worst.turnRms = std::max(worst.turnRms, d.turnRms);
        worst.load = std::max(worst.load, d.load);
      }
      if (atFullSize())
        std::printf(
            "drag %s %3.0f ms: rms %5.2f mm %5.2f mrad, leader %4.2f x, %.2f N in 20 ms, %.4f mJ, link %.4f "
            "mJ\n",
            offCentre ? "off centre" : "centred   ", 1e3 * row.delay, 1e3 * worst.rms, 1e3 * worst.turnRms,
            worst.load / kLoadWithoutDelay, worst.change, 1e3 * worst.created, 1e3 * worst.inLinks);
      if (!offCentre) {
        EXPECT_LE(worst.load, row.load * kLoadWithoutDelay) << row.delay;
      }
      if (row.rms != kOff) {
        EXPECT_LE(worst.rms, row.rms) << row.delay;
      }
    }
  }
}

TEST(LinkFigures, HandsFeelEachOther) {
  for (const Row& row : kRows) {
    for (const bool offCentre : {false, true}) {
      PullFigures worst;
      worst.stiffness = 1e9;
      for (int seed = 1; seed <= seeds(); ++seed) {
        BenchSetup setup = benchAt(row.delay, seed);
        setup.sites = twoHands(firmArm(), firmArm(), offCentre);
        const PullFigures p = pull(setup, LetGo::nobody);
        expectPassive(p, "pull");
        worst.worst(p);
        worst.stiffness = std::min(worst.stiffness, p.stiffness);
      }
      if (atFullSize())
        std::printf("pull %s %3.0f ms: %4.0f N/m, %.2f N in 20 ms at rest, %.4f mJ, link %.4f mJ\n",
                    offCentre ? "off centre" : "centred   ", 1e3 * row.delay, worst.stiffness, worst.change,
                    1e3 * worst.created, 1e3 * worst.inLinks);
      if (!offCentre && row.stiffness != kOff) {
        EXPECT_GE(worst.stiffness, row.stiffness) << row.delay;
      }
    }
  }
}

TEST(LinkFigures, WallIsAsStiffForTheCoHolderAtEveryDelay) {
  struct Pair {
    const char* name;
    haptics::ArmParameters owner, coHolder;
  };
  const Pair pairs[] = {{"relaxed", lightArm(), relaxedArm()},
                        {"mixed", relaxedArm(), firmArm()},
                        {"firm", firmArm(), firmArm()}};
  for (const Row& row : kRows) {
    for (const Pair& pair : pairs) {
      PressFigures worst;
      worst.stiffness = 1e9;
      for (int seed = 1; seed <= seeds(1); ++seed) {
        BenchSetup setup = benchAt(row.delay, seed);
        setup.sites = twoHands(pair.owner, pair.coHolder);
        const PressFigures p = press(setup);
        expectPassive(p, pair.name);
        worst.worst(p);
        worst.stiffness = std::min(worst.stiffness, p.stiffness);
      }
      if (atFullSize())
        std::printf("wall %-7s %3.0f ms: %4.0f N/m, %.4f mJ, link %.4f mJ\n", pair.name, 1e3 * row.delay,
                    worst.stiffness, 1e3 * worst.created, 1e3 * worst.inLinks);
      EXPECT_GE(worst.stiffness, 830.0) << pair.name << " " << row.delay;
    }
  }
}

}  // namespace
}  // namespace tandem::test
