// A link through losses, jitter, blackouts, steps of delay, and hands that let go. Beside each what must
// fail.

#include <gtest/gtest.h>

#include "tests/haptics/link/link_checks.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

constexpr double kForceStep = 0.3;  // N in 20 ms, of which the drag itself makes up to 0.25

BenchSetup setupAt(double delay, int seed, bool offCentre = false) {
  BenchSetup setup;
  setup.network.delay = delay;
  setup.seed = static_cast<unsigned>(seed);
  setup.sites = twoHands(firmArm(), lightArm(), offCentre);
  return setup;
}

void print(const char* what, double delay, const DragFigures& d) {
  if (atFullSize())
    std::printf(
        "%-28s %3.0f ms: %.2f N, %.1f mN m in 20 ms, rms %.1f mm, leader %.2f N, %.4f mJ, link %.4f mJ%s\n",
        what, 1e3 * delay, d.change, 1e3 * d.turnChange, 1e3 * d.rms, d.load, 1e3 * d.created,
        1e3 * d.inLinks, d.astray ? " ASTRAY" : "");
}

DragFigures worstDrag(const std::function<BenchSetup(int)>& setupOf, const DragPlan& plan, int count) {
  DragFigures worst;
  for (int seed = 1; seed <= count; ++seed) {
    const DragFigures d = drag(setupOf(seed), plan);
    worst.worst(d);
    worst.rms = std::max(worst.rms, d.rms);
    worst.turnRms = std::max(worst.turnRms, d.turnRms);
    worst.load = std::max(worst.load, d.load);
  }
  return worst;
}

TEST(LinkDisturbed, BlackoutAtFullSpeedIsNotFelt) {
  for (const double delay : {0.010, 0.025, 0.050, 0.100}) {
    for (const double length : {0.2, 1.0}) {
      for (const bool burst : {true, false}) {
        const auto setupOf = [&](int seed) {
          BenchSetup setup = setupAt(delay, seed, burst);
          setup.network.blackoutAt = 4.0;
          setup.network.blackoutFor = length;
          setup.network.burst = burst;
          return setup;
        };
        const DragFigures d = worstDrag(setupOf, {.from = 3.9, .to = 8.0}, seeds(1));
        print(length < 0.5 ? "blackout of 0.2 s" : "blackout of 1 s", delay, d);
        expectPassive(d, "blackout");
        EXPECT_LE(d.change, kForceStep) << delay << " " << length;
      }
    }
  }
}

TEST(LinkDisturbed, StepOfDelayIsNotFelt) {
  struct Step {
    double from, to;
  };
  for (const Step& step :
       {Step{0.025, 0.250}, Step{0.025, 0.100}, Step{0.100, 0.250}, Step{0.050, 0.070}, Step{0.010, 0.040}}) {
    const auto setupOf = [&](int seed) {
      BenchSetup setup = setupAt(step.from, seed, true);
      setup.network.delayAt = [&step](double t) { return t >= 4.0 && t < 7.0 ? step.to : step.from; };
      return setup;
    };
    const DragFigures d = worstDrag(setupOf, {.from = 3.9, .to = 9.0}, seeds(1));
    print("step of delay", step.to, d);
    expectPassive(d, "step");
    EXPECT_LE(d.change, kForceStep) << step.from << " " << step.to;
  }
}

TEST(LinkDisturbed, HalfTheDelayAsJitterAndAThirdLostIsStable) {
  for (const double delay : {0.010, 0.025, 0.050, 0.100, 0.250}) {
    const auto setupOf = [&](int seed) {
      BenchSetup setup = setupAt(delay, seed, true);
      setup.network.jitter = 0.5;
      setup.network.loss = 0.3;
      return setup;
    };
    const DragFigures d = worstDrag(setupOf, {}, seeds(1));
    print("half jitter, a third lost", delay, d);
    expectPassive(d, "jitter");
    for (const LetGo who : {LetGo::second, LetGo::both}) {
      BenchSetup setup = setupOf(1);
      setup.sites = twoHands(firmArm(), firmArm());
      const PullFigures p = pull(setup, who);
      expectPassive(p, "jitter, let go");
      EXPECT_LT(p.rest, 0.5e-3) << delay;
      EXPECT_LT(p.restless, 0.3) << delay;
    }
  }
}

TEST(LinkDisturbed, LettingGoInTensionSettles) {
  for (const double delay : {0.010, 0.025, 0.050, 0.100, 0.250}) {
    for (const LetGo who : {LetGo::second, LetGo::both}) {
      for (int seed = 1; seed <= seeds(1); ++seed) {
        BenchSetup setup = setupAt(delay, seed);
        setup.sites = twoHands(firmArm(), firmArm(), true);
        const PullFigures p = pull(setup, who);
        if (atFullSize() && seed == 1)
          std::printf("let go %3.0f ms: rest %.3f mm, %.2f N, %.4f mJ, link %.4f mJ\n", 1e3 * delay,
                      1e3 * p.rest, p.restless, 1e3 * p.created, 1e3 * p.inLinks);
        expectPassive(p, "let go");
        EXPECT_LT(p.rest, 0.5e-3) << delay;
        EXPECT_LT(p.restless, 0.3) << delay;
      }
    }
  }
}

TEST(LinkDisturbed, TurnedToAndFroThePartKeepsItsWayAtBothSites) {
  // By 1.2 rad about a slanted axis, dragged at the same time.
  for (const double delay : {0.010, 0.025, 0.050}) {
    const auto setupOf = [&](int seed) { return setupAt(delay, seed); };
    const DragFigures d = worstDrag(setupOf, {.turn = 1.2}, seeds(1));
    print("drag and turn", delay, d);
    if (atFullSize()) std::printf("  turned apart by %.0f mrad rms\n", 1e3 * d.turnRms);
    expectPassive(d, "turn");
    EXPECT_LT(d.turnRms, 0.15) << delay;
  }
}

TEST(LinkDisturbed, DuplicatesChangeNothing) {
  BenchSetup once = setupAt(0.025, 3, true), often = once;
  often.network.duplicate = 0.5;
  const DragFigures a = drag(once, {.until = 5.0}), b = drag(often, {.until = 5.0});
  EXPECT_EQ(a.rms, b.rms);
  EXPECT_EQ(a.load, b.load);
}

TEST(LinkDisturbed, PlainDelayedCouplingMakesEnergy) {
  // The control of the tests above.
  BenchSetup setup = setupAt(0.050, 1);
  setup.makeEnd = [](const haptics::LinkParameters& parameters, double) {
    return std::make_unique<PlainSpringEnd>(PlainSpringEnd::Gains{400.0, 5.0}, parameters);
  };
  setup.sites = twoHands(firmArm(), firmArm());
  const PullFigures p = pull(setup, LetGo::both);
  if (atFullSize())
    std::printf("plain: created %.2f mJ astray %d rest %.2f mm\n", 1e3 * p.created, p.astray, 1e3 * p.rest);
  EXPECT_TRUE(p.astray || p.created > 5e-3);
}

TEST(LinkDisturbed, HoldingTheLastWaveMakesEnergy) {
  // The control of the blackout: the wave goes on as it last was.
  BenchSetup setup = setupAt(0.025, 1);
  setup.network.blackoutAt = 4.0;
  setup.network.blackoutFor = 1.0;
  setup.makeEnd = holdingTheLastWave(setup.network);
  const DragFigures d = drag(setup, {.from = 3.9, .to = 8.0});
  print("hold last", 0.025, d);
  EXPECT_GT(d.inLinks, kEnergyBound);
}

}  // namespace
}  // namespace tandem::test
