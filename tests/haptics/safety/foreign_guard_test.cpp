#include "haptics/safety/foreign_guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace tandem::haptics {
namespace {

constexpr double kStiffness = 800.0;  // N/m

struct Guarded {
  ForeignGuard guard;
  TickParameters parameters;
  std::uint32_t flags = 0;
  glm::dvec3 last{0.0, 0.0, 0.0};

  glm::dvec3 step(const glm::dvec3& wanted, double foreign,
                  const glm::dvec3& displacement = glm::dvec3(0.0)) {
    flags = 0;
    const ForeignGuard::Tick tick{foreign, foreign >= 0.0, displacement, kStiffness};
    last = guard.step(Wrench{wanted, glm::dvec3(0.0)}, tick, parameters, flags).force;
    return last;
  }
};

TEST(ForeignGuard, PassesToTheBitWhatNoOtherSiteMoves) {
  Guarded hand;
  std::mt19937_64 dice(1);
  std::uniform_real_distribution<> force(-3.0, 3.0);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 wanted(force(dice), 1.0, 2.0);
    EXPECT_EQ(hand.step(wanted, -1.0, {1e-3 * force(dice), 0.0, 0.0}), wanted);
    EXPECT_EQ(hand.flags, 0u);
  }
}

TEST(ForeignGuard, LetsNoFastPartChangeTheForceFaster) {
  Guarded hand;
  std::mt19937_64 dice(1);
  std::uniform_real_distribution<> force(-9.0, 9.0);
  glm::dvec3 before(0.0);
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 wanted(force(dice), 1.0, -2.0);
    const glm::dvec3 now = hand.step(wanted, 2e-3, {1e-4 * force(dice), 0.0, 0.0});
    EXPECT_LE(glm::length(now - before), hand.parameters.foreign.slew * hand.parameters.dt * (1.0 + 1e-9));
    before = now;
  }
}

TEST(ForeignGuard, GivesTheHandNoMoreThanTheAccount) {
  // A part that always presses with 3 N drives a hand of any mass and damping.
  for (const double mass : {0.05, 0.3, 1.5})
    for (const double damping : {0.0, 1.0, 10.0}) {
      Guarded hand;
      double v = 0.0, given = 0.0, d = 0.0, most = 0.0;
      for (int i = 0; i < 10000; ++i) {
        const double f = hand.step({3.0, 0.0, 0.0}, 1e-3, {d, 0.0, 0.0}).x;
        v += 1e-3 * (f - damping * v) / mass;
        d = 1e-3 * v;
        given += f * d;
        most = std::max(most, given);
      }
      EXPECT_LE(most, 10e-3) << mass << " " << damping;
    }
}

TEST(ForeignGuard, PassesWhatTheHandMakesOfACalmPart) {
  Guarded hand;
  for (int i = 1; i < 15; ++i) {
    const double depth = 2e-4 * i;  // at 0.2 m/s
    EXPECT_NEAR(hand.step({kStiffness * depth, 0.0, 0.0}, 1e-6, {-2e-4, 0.0, 0.0}).x, kStiffness * depth,
                0.02);
  }
}

TEST(ForeignGuard, YieldsButDoesNotPull) {
  Guarded hand;
  for (int i = 0; i < 300; ++i) hand.step({2.0, 0.0, 0.0}, 1e-3);
  for (int i = 0; i < 300; ++i) EXPECT_GE(hand.step(glm::dvec3(0.0), -1.0, {5e-4, 0.0, 0.0}).x, 0.0);
  EXPECT_EQ(hand.last, glm::dvec3(0.0));
}

TEST(ForeignGuard, GoesOnWhileAPartThatWasStruckMaySwing) {
  for (const bool held : {false, true}) {
    ForeignGuard guard;
    const TickParameters parameters;
    std::uint32_t flags = 0;
    ForeignGuard::Tick tick{1.0, false, glm::dvec3(0.0), kStiffness, held};
    static_cast<void>(guard.step({}, tick, parameters, flags));
    tick.foreign = -1.0;
    tick.held = false;
    for (int i = 0; i < 100; ++i) static_cast<void>(guard.step({}, tick, parameters, flags));
    const Wrench swing{{2.0, 0.0, 0.0}, glm::dvec3(0.0)};
    EXPECT_EQ(guard.step(swing, tick, parameters, flags).force.x < 0.1, held);
  }
}

TEST(ForeignGuard, CanBeSwitchedOff) {
  Guarded hand;
  hand.parameters.foreign.slew = 0.0;
  EXPECT_EQ(hand.step({3.0, 0.0, 0.0}, 1.0).x, 3.0);
}

}  // namespace
}  // namespace tandem::haptics
