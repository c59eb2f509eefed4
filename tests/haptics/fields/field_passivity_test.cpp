// Sources among a scene's fields under the passivity controller: what they give is theirs, not the
// sampling's.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "haptics/operator/simulated_hand.h"
#include "haptics/safety/device_defaults.h"
#include "haptics/safety/passivity_controller.h"
#include "tests/haptics/fields/field_samples.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::haptics {
namespace {

using namespace test;

ForceField waveform(assets::FieldWaveform::Kind kind, double hz) {
  ForceField field;
  field.kind = Kind::waveform;
  field.force = {1.0, 0.0, 0.0};
  field.waveform.kind = kind;
  field.waveform.frequency = hz;
  field.waveform.width = 0.0;
  return field;
}

/// A desktop arm in a relaxed hand, or let go of, with the limits of a real session.
struct Desk {
  explicit Desk(const std::vector<ForceField>& fields, bool holds = true, double friction = 0.05)
      : device{.friction = friction}, hand({}, device, {}), probe(sceneWith(fields)) {
    DeviceLimits limits;
    limits.maxForce = device.forceMax;
    limits.damping = device.damping;
    fitToDevice(limits, 0.0, probe.parameters);
    target.holdsStylus = holds;
  }
  void tick(double push = 0.0) {
    probe.sample = hand.sample(1e-3 * ticks++);
    probe.tick();
    flags |= probe.out.flags;
    most = std::max(most, glm::length(probe.out.hands[0].toHand.force));
    hand.step(target, probe.out.hands[0].toHand.force + glm::dvec3(push, 0.0, 0.0), 1e-3);
  }
  SimulatedDeviceParameters device;
  SimulatedHand hand;
  HandProbe probe;
  HandTarget target;
  int ticks = 0;
  std::uint32_t flags = 0;
  double most = 0.0;  // N
};

TEST(FieldPassivity, AWaveformIsFeltAsItIsWhateverItsFrequency) {
  for (const auto kind : {assets::FieldWaveform::Kind::sine, assets::FieldWaveform::Kind::square}) {
    for (const double hz : {2.0, 12.0, 30.0, 64.0, 200.0, 400.0}) {
      for (const bool holds : {true, false}) {
        Desk desk({waveform(kind, hz)}, holds);
        for (int i = 0; i < 1500; ++i) desk.tick();
        EXPECT_LE(desk.most, 1.0 + 1e-9) << hz << ' ' << holds;
        EXPECT_GT(desk.most, 0.95) << hz << ' ' << holds;  // 200 and 400 Hz are sampled at sin 72 degrees
        EXPECT_EQ(desk.flags & (kFlagPassivity | kFlagSlewLimited), 0u) << hz << ' ' << holds;
      }
    }
  }
}

TEST(FieldPassivity, ADeviceThatFollowsAtALimitedRateCutsAWaveformAboveIt) {
  for (const double hz : {60.0, 70.0}) {  // 400 N/s are 1 N at 63.7 Hz
    Desk desk({waveform(assets::FieldWaveform::Kind::sine, hz)});
    for (int i = 0; i < 200; ++i) desk.tick();
    desk.flags = 0;
    desk.probe.parameters.deviceSlewLimit = 400.0;
    for (int i = 0; i < 200; ++i) desk.tick();
    EXPECT_EQ((desk.flags & kFlagSlewLimited) != 0, hz > 64.0);
  }
}

/// The largest force on a device of 45 g that a controller answers a source of 1 N with.
double maxUnder(bool announced) {
  PassivityController controller;
  SimulatedDeviceParameters device;
  SimulatedHand hand({}, device, {});
  double largest = 0.0, before = 0.0;
  for (int i = 0; i < 1500; ++i) {
    const double force = std::sin(2.0 * std::numbers::pi * 200.0 * 1e-3 * i + 0.3);
    const glm::dvec3 felt(force, 0.0, 0.0), byTime(announced ? force - before : 0.0, 0.0, 0.0);
    const glm::dvec3 sent = felt + controller.step(hand.sample(1e-3 * i).worldFromDevice.position, felt,
                                                   byTime, 0.5 * device.damping, 1e-3);
    controller.sent(sent);
    largest = std::max(largest, glm::length(sent));
    before = force;
    hand.step({}, sent, 1e-3);
  }
  return largest;
}

TEST(FieldPassivity, AControllerThatIsNotToldOfTheSourceAddsToIt) {
  EXPECT_LE(maxUnder(true), 1.0 + 1e-9);
  EXPECT_GT(maxUnder(false), 1.8);  // the control: 1.92 N
}

/// Peak to peak of the last second of a free device in a spring beyond what it bears, with a waveform, m.
double swingInAStiffSpring(bool controlled) {
  ForceField stiff = spring(500.0);
  stiff.maxForce = 1e6;
  Desk desk({stiff, waveform(assets::FieldWaveform::Kind::sine, 7.0)}, false, 0.0);
  desk.probe.parameters.passivity = controlled;
  desk.probe.parameters.forceLimit = 1e6;
  double low = 1e9, high = -1e9;
  for (int i = 0; i < 4000; ++i) {
    desk.tick();
    const double x = desk.hand.devicePose().position.x;
    if (!(std::abs(x) < 1.0)) return 1e9;
    if (i >= 3000) low = std::min(low, x), high = std::max(high, x);
  }
  return high - low;
}

TEST(FieldPassivity, WhatSamplingMakesOfASpringIsStillTakenBackBesideASource) {
  // 1 N on 500 N/m at a tenth of the resonance: 2 mm either way, and some of the resonance's own.
  EXPECT_LT(swingInAStiffSpring(true), 8e-3);
  EXPECT_GT(swingInAStiffSpring(false), 20e-3);
}

}  // namespace
}  // namespace tandem::haptics
