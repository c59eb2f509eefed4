// Force fields: each law against its analytic force and against the slope of its potential.

#include "haptics/fields/force_fields.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/haptics/fields/field_samples.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::haptics {
namespace {

using assets::FieldWaveform;
using assets::ForceField;
using namespace test;
using Kind = ForceField::Kind;

glm::dvec3 forceAt(const ForceField& field, const glm::dvec3& x, const glm::dvec3& v = glm::dvec3(0.0),
                   double time = 0.0) {
  const FieldForce law(field);
  const FieldAction a = law.act({x, v, time}, law.path() != nullptr ? law.path()->nearest(x) : 0.0);
  return a.stored + a.source + a.damping;
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
  EXPECT_LT(glm::distance(a, b), tolerance)
      << a.x << "," << a.y << "," << a.z << " against " << b.x << "," << b.y << "," << b.z;
}

TEST(FieldForce, SpringsPullTowardsPointLineAndPlane) {
  ForceField f = spring(100.0);
  const glm::dvec3 x(0.003, 0.004, -0.005);
  expectNear(forceAt(f, x), -100.0 * x, 1e-12);
  f.anchor = ForceField::Anchor::line;
  expectNear(forceAt(f, x), -100.0 * glm::dvec3(0.003, 0.0, -0.005), 1e-12);
  f.anchor = ForceField::Anchor::plane;
  expectNear(forceAt(f, x), glm::dvec3(0.0, -0.4, 0.0), 1e-12);
  f.oneSided = true;
  expectNear(forceAt(f, x), glm::dvec3(0.0), 1e-15);
  expectNear(forceAt(f, -x), glm::dvec3(0.0, 0.4, 0.0), 1e-12);
}

TEST(FieldForce, ASpringIsFreeWithinItsRadiusAndHoldsItsMaximumBeyond) {
  ForceField f = spring(100.0);
  f.radius = 0.01;
  f.maxForce = 0.5;
  expectNear(forceAt(f, {0.0, 0.009, 0.0}), glm::dvec3(0.0), 1e-15);
  expectNear(forceAt(f, {0.0, 0.012, 0.0}), {0.0, -0.2, 0.0}, 1e-12);
  expectNear(forceAt(f, {0.0, 5.0, 0.0}), {0.0, -0.5, 0.0}, 1e-12);
}

TEST(FieldForce, GravityFallsWithTheSquareOutsideAndIsLinearInside) {
  const ForceField f = gravity(2e-3, 0.05);
  for (const double d : {0.05, 0.07, 0.2, 3.0})
    expectNear(forceAt(f, {d, 0.0, 0.0}), {-2e-3 / (d * d), 0.0, 0.0}, 1e-12);
  for (const double d : {0.0, 0.01, 0.049})
    expectNear(forceAt(f, {0.0, d, 0.0}), {0.0, -2e-3 * d / (0.05 * 0.05 * 0.05), 0.0}, 1e-12);
  expectNear(forceAt(gravity(-2e-3, 0.05), {0.1, 0.0, 0.0}), {0.2, 0.0, 0.0}, 1e-12);
}

TEST(ForceFields, SeveralCentresAddUpAndFollowTheirParts) {
  assets::Scene scene = sceneWith({gravity(1e-3, 0.02), gravity(3e-3, 0.01), gravity(2e-3, 0.01)});
  scene.parts.resize(1);
  scene.parts[0].movable = true;
  scene.parts[0].worldFromPart.position = {0.3, 0.0, 0.0};
  scene.fields[1].partFromField.position = {0.0, 0.2, 0.0};
  scene.fields[2].part = 0;
  HandProbe probe(std::move(scene));
  const auto pull = [](const glm::dvec3& from, const glm::dvec3& to, double k) {
    const glm::dvec3 r = to - from;
    return r * (k / std::pow(glm::length(r), 3.0));
  };
  const glm::dvec3 x(0.1, 0.05, -0.02);
  const glm::dvec3 still = pull(x, {0.0, 0.0, 0.0}, 1e-3) + pull(x, {0.0, 0.2, 0.0}, 3e-3);
  expectNear(probe.at(x).hands[0].toHand.force, still + pull(x, {0.3, 0.0, 0.0}, 2e-3), 1e-12);
  probe.moved.push_back({0, Pose{{0.1, 0.3, 0.0}, {1.0, 0.0, 0.0, 0.0}}, Twist{}});
  expectNear(probe.at(x).hands[0].toHand.force, still + pull(x, {0.1, 0.3, 0.0}, 2e-3), 1e-12);
}

TEST(FieldForce, DampersOpposeEachAxisByItsOwnRate) {
  ForceField f;
  f.kind = Kind::damper;
  f.damping = {1.0, 2.0, 0.0};
  expectNear(forceAt(f, glm::dvec3(7.0), {0.1, -0.2, 0.3}), {-0.1, 0.4, 0.0}, 1e-12);
}

TEST(FieldForce, AViscosityFillsItsRegionAndFadesAtItsBorder) {
  ForceField f;
  f.kind = Kind::viscosity;
  f.damping = glm::dvec3(4.0);
  f.region = sphere(0.05, 0.01);
  const glm::dvec3 v(0.1, 0.0, 0.0);
  expectNear(forceAt(f, {0.039, 0.0, 0.0}, v), {-0.4, 0.0, 0.0}, 1e-12);
  expectNear(forceAt(f, {0.045, 0.0, 0.0}, v), {-0.2, 0.0, 0.0}, 1e-12);  // half way through the fade
  expectNear(forceAt(f, {0.051, 0.0, 0.0}, v), {0.0, 0.0, 0.0}, 1e-15);
}

TEST(Waveform, EachShapeHasItsClosedForm) {
  FieldWaveform w;
  w.frequency = 10.0;
  w.start = 1.0;
  w.stop = 2.0;
  EXPECT_EQ(waveformValue(w, 0.999), 0.0);
  EXPECT_EQ(waveformValue(w, 2.0), 0.0);
  EXPECT_EQ(waveformValue(w, std::numeric_limits<double>::quiet_NaN()), 0.0);
  for (double t = 1.0; t < 2.0; t += 0.0137)
    EXPECT_NEAR(waveformValue(w, t), std::sin(20.0 * M_PI * (t - 1.0)), 1e-9);
  w.kind = FieldWaveform::Kind::square;
  w.width = 0.01;
  EXPECT_NEAR(waveformValue(w, 1.0 + 1e-12), 0.0, 1e-6);
  EXPECT_NEAR(waveformValue(w, 1.006), 1.0, 1e-12);
  EXPECT_NEAR(waveformValue(w, 1.05), 0.0, 1e-9);
  EXPECT_NEAR(waveformValue(w, 1.056), -1.0, 1e-12);
  for (double t = 1.0; t < 1.999; t += 1e-4)
    EXPECT_LT(std::abs(waveformValue(w, t + 1e-4) - waveformValue(w, t)), 1e-4 * 3.0 / 0.01 + 1e-12);
  w.kind = FieldWaveform::Kind::pulses;
  EXPECT_NEAR(waveformValue(w, 1.005), 1.0, 1e-12);
  EXPECT_NEAR(waveformValue(w, 1.0025), 0.5, 1e-12);
  EXPECT_EQ(waveformValue(w, 1.05), 0.0);
  w.kind = FieldWaveform::Kind::chirp;
  w.endFrequency = 50.0;
  w.sweep = 0.5;
  // The phase is the integral of a frequency that grows from 10 to 50 Hz.
  const double s = 0.3;
  EXPECT_NEAR(waveformValue(w, 1.3), std::sin(2.0 * M_PI * (10.0 * s + 0.5 * 80.0 * s * s)), 1e-9);
  EXPECT_NEAR(waveformValue(w, 1.8), waveformValue(w, 1.3), 1e-9);  // the next sweep
}

TEST(ForceFields, AWaveformFollowsTheSessionsClockOrElseTheReadings) {
  ForceField f;
  f.kind = Kind::waveform;
  f.force = {0.0, 2.0, 0.0};
  f.waveform.frequency = 5.0;
  const assets::Scene scene = sceneWith({f});
  const ContactScene contact(scene, 1);
  TickState state(contact);
  DeviceSample sample;
  sample.valid = true;
  sample.time = 0.03;
  const TickParameters free = springOnly();
  expectNear(
      tick({.hands = {{{sample}}}, .moved = {}, .commands = {}}, contact, free, state).hands[0].toHand.force,
      {0.0, 2.0 * std::sin(2.0 * M_PI * 5.0 * 0.03), 0.0}, 1e-12);
  expectNear(
      tick({.hands = {{{sample}}}, .moved = {}, .commands = {}, .sessionTime = 100.05}, contact, free, state)
          .hands[0]
          .toHand.force,
      {0.0, 2.0, 0.0}, 1e-9);
}

TEST(FieldForce, IsMinusTheSlopeOfItsPotentialEverywhere) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.06, 0.06);
  const std::vector<ForceField> all = storedFields();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const FieldForce law(all[i]);
    const auto act = [&](const glm::dvec3& x) {
      return law.act({x, glm::dvec3(0.0), 0.0}, law.path() != nullptr ? law.path()->nearest(x) : 0.0);
    };
    for (int n = 0; n < 300; ++n) {
      const glm::dvec3 x(place(random), place(random), place(random));
      const FieldAction here = act(x);
      ASSERT_FALSE(here.limited) << i;
      glm::dvec3 slope;
      constexpr double h = 1e-6;
      for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 step(0.0);
        step[axis] = h;
        slope[axis] = (act(x - step).potential - act(x + step).potential) / (2.0 * h);
      }
      ASSERT_LT(glm::distance(slope, here.stored), 2e-4 * (1.0 + glm::length(slope)))
          << i << " at " << x.x << "," << x.y << "," << x.z;
    }
  }
}

TEST(ForceFields, ASceneWithoutThemCostsNothingAndAnInvalidReadingFeelsNone) {
  EXPECT_TRUE(ForceFields(sceneWith({})).empty());
  HandProbe probe(sceneWith({spring(100.0)}));
  EXPECT_NEAR(probe.at({0.01, 0.0, 0.0}).hands[0].toHand.force.x, -1.0, 1e-12);
  probe.sample.worldFromDevice.position.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(probe.tick().hands[0].toHand.force, glm::dvec3(0.0));
  probe.sample.worldFromDevice.position.x = 0.02;
  EXPECT_NEAR(probe.tick().hands[0].toHand.force.x, -2.0, 1e-12);
}

TEST(ForceFields, FieldsBeyondTheCapacityAreLeftOutAndFlagged) {
  HandProbe probe(sceneWith(std::vector<ForceField>(assets::kMaxForceFields + 3, spring(1.0))));
  const TickOutput& out = probe.at({0.01, 0.0, 0.0});
  EXPECT_NE(out.flags & kFlagOverflow, 0u);
  EXPECT_NEAR(out.hands[0].toHand.force.x, -0.01 * static_cast<double>(assets::kMaxForceFields), 1e-12);
}

}  // namespace
}  // namespace tandem::haptics
