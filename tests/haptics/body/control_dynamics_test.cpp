#include "haptics/body/control_dynamics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/haptics/grasp/control_scenes.h"

namespace tandem::test {
namespace {

using assets::Control;
using assets::ControlKind;
using haptics::AxisLoad;
using haptics::ControlState;

Control slider(double min, double max) {
  return controlAlong(ControlKind::slider, {1.0, 0.0, 0.0}, glm::dvec3(0.0), {}, min, max);
}

/// Everything at once: spring, unevenly spaced detents with plateaus between some, a click.
Control rich() {
  Control c = slider(0.0, 0.1);
  c.springStiffness = 5.0;
  c.springRest = 0.02;
  c.detents = {{0.01, 0.03, 0.06, 0.09}, 0.7, 0.025};
  c.click = {0.045, 1.5, 0.004};
  return c;
}

std::vector<Control> samples() {
  Control single = slider(-1.0, 1.0);
  single.detents = {{0.2}, 2.0, 0.3};
  return {rich(), single, buttonScene(1.0).scene.controls[0], dialScene(1.0).scene.controls[0]};
}

double kinetic(const Control& c, const ControlState& s) { return 0.5 * c.inertia * s.rate * s.rate; }

TEST(ControlDynamics, ResistanceIsTheGradientOfTheStoredEnergy) {
  for (const Control& c : samples()) {
    const double h = 1e-6 * (c.max - c.min);
    for (int i = 1; i < 2000; ++i) {
      const double q = c.min + (c.max - c.min) * (i + 0.3) / 2001.0;
      const double slope = (haptics::storedEnergy(c, q + h) - haptics::storedEnergy(c, q - h)) / (2.0 * h);
      const double scale = c.detents.force + c.click.drop + c.springStiffness * (c.max - c.min);
      ASSERT_NEAR(haptics::resistance(c, q), slope, 1e-4 * scale) << q;
    }
  }
}

TEST(ControlDynamics, TheStatedSteepnessIsABound) {
  for (const Control& c : samples()) {
    const double bound = haptics::steepestResistance(c) + c.springStiffness;
    const double h = 1e-5 * (c.max - c.min);
    double steepest = 0.0;
    for (int i = 0; i < 20'000; ++i) {
      const double q = c.min + (c.max - c.min - h) * i / 20'000.0;
      if (c.endless && std::abs(q) > kPi - 2.0 * h) continue;
      steepest = std::max(steepest, std::abs(haptics::resistance(c, q + h) - haptics::resistance(c, q)) / h);
    }
    EXPECT_LE(steepest, bound * (1.0 + 1e-6));
    EXPECT_GE(steepest, 0.3 * bound);  // and not an idle one
  }
}

TEST(ControlDynamics, DetentsAreWellsOfTheStatedForceAndWidth) {
  const Control c = rich();
  Control bare = c;
  bare.springStiffness = bare.click.drop = 0.0;
  for (const double well : c.detents.places) EXPECT_NEAR(haptics::resistance(bare, well), 0.0, 1e-12);
  // Gaps of 20 and 30 mm: wells of 20 and of 25 mm. The peak lies a quarter of the width from the well.
  EXPECT_NEAR(haptics::resistance(bare, 0.01 + 0.005), 0.7, 1e-12);
  EXPECT_NEAR(haptics::resistance(bare, 0.03 - 0.005), -0.7, 1e-12);
  EXPECT_NEAR(haptics::resistance(bare, 0.03 + 0.00625), 0.7, 1e-12);
  EXPECT_EQ(haptics::resistance(bare, 0.045), 0.0);  // between 30 + 12.5 and 60 - 12.5 mm nothing holds
  // Depth: force * width / pi.
  EXPECT_NEAR(haptics::storedEnergy(bare, 0.045) - haptics::storedEnergy(bare, 0.03), 0.7 * 0.025 / kPi,
              1e-12);
}

/// Pushes and releases at random; the most by which one tick ever gained energy that nothing put in, as a
/// share of the depth of its wells.
template <typename Step>
double mostGained(Control c, std::uint64_t seed, Step&& step) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  ControlState state{c.initial, 0.0};
  double worst = 0.0, force = 0.0;
  const double depth =
      haptics::storedEnergy(c, c.max) + c.detents.force * (c.max - c.min) + c.click.drop * c.click.width;
  for (int i = 0; i < 4000; ++i) {
    if (i % 40 == 0) force = i % 80 == 0 ? 0.0 : unit(random) * 5.0 * (c.detents.force + c.click.drop);
    const ControlState before = state;
    step(c, force, state);
    if (!std::isfinite(state.value) || !std::isfinite(state.rate)) return 1e300;
    double way = state.value - before.value;
    if (c.endless) way = std::remainder(way, c.max - c.min);
    const double gained = kinetic(c, state) + haptics::storedEnergy(c, state.value) - kinetic(c, before) -
                          haptics::storedEnergy(c, before.value) - force * way;
    worst = std::max(worst, gained / depth);
  }
  return worst;
}

TEST(ControlDynamics, CreatesNoEnergyWhateverTheMassAndTheDepthOfItsDetents) {
  std::uint64_t seed = 1;
  for (const double mass : {1e-6, 1e-3, 1.0}) {
    for (const double stronger : {1.0, 100.0, 1e4}) {
      for (Control c : samples()) {
        // At 1e4 the dial would turn more than half around in a tick, and the way could not be told from its
        // value.
        if (c.endless && stronger > 100.0) continue;
        c.inertia *= mass;
        c.detents.force *= stronger;
        c.click.drop *= stronger;
        const double steepest = haptics::steepestResistance(c);
        EXPECT_LE(mostGained(c, ++seed,
                             [&](const Control& control, double force, ControlState& state) {
                               haptics::stepControl(control, steepest, {force, 0.0, 0.0}, 1e-3, state);
                             }),
                  1e-9)
            << mass << " " << stronger;
      }
    }
  }
}

TEST(ControlDynamics, ExplicitIntegrationOfStiffDetentsCreatesEnergy) {
  // The control for the test above: the same 20 g slider and its wells, integrated explicitly at the same
  // rate.
  Control c = rich();
  c.detents.force *= 100.0;
  const double gained = mostGained(c, 3, [](const Control& control, double force, ControlState& state) {
    state.rate += 1e-3 / control.inertia * (force - haptics::resistance(control, state.value));
    state.value += 1e-3 * state.rate;
  });
  EXPECT_GT(gained, 1e-2);
}

TEST(ControlDynamics, StopsDoNotThrowBack) {
  Control c = slider(0.0, 0.05);
  ControlState state{0.0, 1.0};
  for (int i = 0; i < 60; ++i) haptics::stepControl(c, 0.0, {}, 1e-3, state);
  EXPECT_EQ(state.value, 0.05);
  EXPECT_EQ(state.rate, 0.0);
}

TEST(ControlDynamics, DryFrictionHoldsBelowItsForceAndTakesItOffAbove) {
  Control c = slider(0.0, 10.0);
  c.friction = 0.5;
  ControlState state{1.0, 0.0};
  for (int i = 0; i < 100; ++i) haptics::stepControl(c, 0.0, {0.499, 0.0, 0.0}, 1e-3, state);
  EXPECT_EQ(state.value, 1.0);
  for (int i = 0; i < 100; ++i) haptics::stepControl(c, 0.0, {0.6, 0.0, 0.0}, 1e-3, state);
  EXPECT_NEAR(state.rate, (0.6 - 0.5) / c.inertia * 0.1, 1e-9);
  for (int i = 0; i < 1000; ++i) haptics::stepControl(c, 0.0, {}, 1e-3, state);
  EXPECT_EQ(state.rate, 0.0);  // it stops, and does not turn back
}

TEST(ControlDynamics, ADialRestsInTheDetentThatItIsNearestTo) {
  const Control c = dialScene(1.0).scene.controls[0];
  const double steepest = haptics::steepestResistance(c);
  for (int i = 0; i < 48; ++i) {
    const double from = -kPi + (i + 0.4) * kPi / 24.0;
    Control damped = c;
    damped.damping = 0.01;  // creeps, so that it does not roll through
    ControlState state{from, 0.0};
    for (int n = 0; n < 5000; ++n) haptics::stepControl(damped, steepest, {}, 1e-3, state);
    const double nearest = std::round(from / (kPi / 6.0)) * (kPi / 6.0);
    EXPECT_NEAR(std::remainder(state.value - nearest, 2.0 * kPi), 0.0, 1e-6) << from;
  }
}

TEST(ControlDynamics, TheSameMotionAtEveryScale) {
  for (const double s : {1e-3, 20.0}) {
    const Control one = buttonScene(1.0).scene.controls[0], scaled = buttonScene(s).scene.controls[0];
    ControlState a, b;
    for (int i = 0; i < 2000; ++i) {
      const double push = 2.5 * std::sin(0.01 * i);
      haptics::stepControl(one, haptics::steepestResistance(one), {push, 0.0, 0.0}, 1e-3, a);
      haptics::stepControl(scaled, haptics::steepestResistance(scaled), {push * s, 0.0, 0.0}, 1e-3, b);
      ASSERT_NEAR(b.value / s, a.value, 1e-12) << s << " " << i;
    }
  }
}

}  // namespace
}  // namespace tandem::test
