// A device on a virtual wall, closed through the tick: m = 45 g, damping b, position quantised or not, 1 kHz,
// pushed by a steady 1 N. Between ticks the device moves under a constant force, whose exact solution is
// used, so that the limits found are the sampling's and not an integrator's.
//
// The exact limit of this loop is K < b^2 (1 - a) / (m (1 - a) - a b T) with a = exp(-b T / m): 2 b / T (1 +
// b T / 6 m) to first order, so 2 b / T to within 1 % for b <= 2 N·s/m.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "haptics/operator/simulated_hand.h"
#include "haptics/safety/device_defaults.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

constexpr double kPeriod = 1e-3, kMass = 0.045, kPush = 1.0, kQuantum = 0.055e-3;
constexpr double kDiverged = 1e9;

struct Loop {
  double stiffness = 0.0, damping = 0.0, quantum = 0.0;
  bool controlled = false;
  double counted = 0.5;  // share of b that the controller counts on
};

struct Outcome {
  double swing = 0.0;    // m, peak to peak, of the last second
  double created = 0.0;  // J: the most that wall and damping together gave out since any earlier moment
  double control = 0.0;  // N, the largest force that is not the wall's
  bool acted = false;
};

Outcome run(const Loop& loop, double seconds = 8.0) {
  SceneBuilder b;
  b.addPart(sheetMesh(0.4, 1));
  haptics::TickParameters p = springOnly(loop.stiffness);
  p.passivity = loop.controlled;
  p.deviceDamping = loop.counted * loop.damping;
  HandProbe hand(b.scene, p);
  const double a = std::exp(-loop.damping * kPeriod / kMass);
  double z = 1e-3, v = 0.0, energy = 0.0, least = 0.0, low = 1e9, high = -1e9;
  Outcome outcome;
  const int ticks = static_cast<int>(seconds / kPeriod);
  for (int i = 0; i < ticks; ++i) {
    const double reading = loop.quantum > 0.0 ? loop.quantum * std::floor(z / loop.quantum + 0.5) : z;
    hand.at({0.0, 0.0, reading});
    const double force = hand.out.hands[0].toHand.force.z;
    outcome.acted = outcome.acted || (hand.out.flags & haptics::kFlagPassivity) != 0;
    outcome.control = std::max(outcome.control, std::abs(force - std::max(0.0, -loop.stiffness * reading)));
    const double settled = (force - kPush) / loop.damping;
    const double before = z, speed = v;
    z += settled * kPeriod + (v - settled) * (1.0 - a) * kMass / loop.damping;
    v = settled + (v - settled) * a;
    if (!(std::abs(z) < 1.0)) return {kDiverged, kDiverged, outcome.control};
    // What the device's damping took is what came in and did not stay as kinetic energy.
    const double kinetic = 0.5 * kMass * (v * v - speed * speed);
    const double lost = (force - kPush) * (z - before) - kinetic;
    energy += force * (z - before) - lost;
    const double stored = 0.5 * loop.stiffness * std::min(0.0, z) * std::min(0.0, z);
    least = std::min(least, energy + stored);
    outcome.created = std::max(outcome.created, energy + stored - least);
    if (i < ticks - 1000) continue;
    low = std::min(low, z);
    high = std::max(high, z);
  }
  outcome.swing = high - low;
  return outcome;
}

double twoBOverT(double damping) { return 2.0 * damping / kPeriod; }

/// Near the limit an oscillation dies with (1 - K T / 2 b) b / 2 m: by this many s it is gone.
double untilQuiet(double damping, double share) { return 1.0 + 12.0 * 2.0 * kMass / (damping * share); }

TEST(ClosedLoop, AContinuousDeviceComesToRestUpToNearTheStiffestStable) {
  for (const double b : {0.5, 1.0, 2.0}) {
    EXPECT_LT(run({0.95 * twoBOverT(b), b}, untilQuiet(b, 0.05)).swing, 2e-5) << b;
  }
  EXPECT_LT(run({0.8 * twoBOverT(0.1), 0.1}, untilQuiet(0.1, 0.2)).swing, 2e-5);
}

TEST(ClosedLoop, AQuantisedDeviceCyclesWithinThreeQuantaAndUnderControlWithinTwo) {
  for (const double b : {0.1, 0.5, 1.0, 2.0}) {
    const double k = 0.95 * twoBOverT(b);
    // 0.1 N·s/m would take minutes to come to its cycle.
    if (b > 0.1) {
      EXPECT_LE(0.5 * run({k, b, kQuantum}, untilQuiet(b, 0.05)).swing, 3.0 * kQuantum) << b;
    }
    EXPECT_LE(0.5 * run({k, b, kQuantum, true}, untilQuiet(b, 0.5)).swing, 2.0 * kQuantum) << b;
  }
}

TEST(ClosedLoop, WithoutAControllerHalfAsStiffAgainNeverRests) {
  for (const double b : {0.1, 0.5, 1.0, 2.0}) {
    EXPECT_GT(run({1.5 * twoBOverT(b), b}).swing, 5e-4) << b;
    EXPECT_GT(run({1.5 * twoBOverT(b), b, kQuantum}).swing, 5e-4) << b;
  }
}

TEST(ClosedLoop, ThePassivityControllerRestsAtThreeTimesTheStiffestStable) {
  for (const double b : {0.1, 0.5, 1.0, 2.0}) {
    for (const double quantum : {0.0, kQuantum}) {
      for (const double times : {0.95, 1.5, 2.0, 3.0}) {
        const Outcome outcome = run({times * twoBOverT(b), b, quantum, true}, untilQuiet(b, 0.5));
        EXPECT_LE(0.5 * outcome.swing, std::max(2.0 * quantum, 2e-5)) << b << ' ' << quantum << ' ' << times;
        // No bursts: damping never exceeds what one tick of the way changes the spring by.
        EXPECT_LT(outcome.control, times * twoBOverT(b) * 1e-3) << b << ' ' << quantum << ' ' << times;
      }
    }
  }
}

/// A relaxed hand that holds the device presses it onto a wall; the last second at rest.
struct Rest {
  double way = 0.0, force = 0.0;  // peak to peak, m and N
};

/// With `drift`, m a tick, the reading creeps by as little: no encoder at a mark is to be seen in it. With a
/// `viscosity`, N·s/m, the wall is one of more than a spring.
Rest handAtRest(const haptics::TickParameters& parameters, const haptics::SimulatedDeviceParameters& device,
                double drift = 0.0, double viscosity = 0.0) {
  SceneBuilder b;
  if (viscosity > 0.0) {
    b.scene.surfaces.push_back({});
    b.scene.surfaces[0].viscosity = viscosity;
    b.scene.materials[0].surface = 0;
  }
  b.addPart(sheetMesh(0.4, 1));
  HandProbe probe(b.scene, parameters);
  Pose start;
  start.position.z = 0.005;
  haptics::SimulatedHand hand({}, device, start);
  haptics::HandTarget target;
  double low = 1e9, high = -1e9, least = 1e9, most = -1e9;
  for (int i = 0; i < 8000; ++i) {
    target.worldFromTarget.position.z = std::max(-0.02, 0.005 - 2e-5 * i);
    probe.sample = hand.sample(1e-3 * i);
    probe.sample.worldFromDevice.position.z += drift * i;
    const double force = probe.tick().hands[0].toHand.force.z;
    hand.step(target, probe.out.hands[0].toHand.force, 1e-3);
    if (i < 7000) continue;
    low = std::min(low, hand.devicePose().position.z);
    high = std::max(high, hand.devicePose().position.z);
    least = std::min(least, force);
    most = std::max(most, force);
  }
  return {high - low, most - least};
}

/// What `tandem join` makes of a device of this damping, contact damping left out.
haptics::TickParameters defaultsFor(const haptics::SimulatedDeviceParameters& device) {
  haptics::DeviceLimits limits;
  limits.maxForce = device.forceMax;
  limits.mass = device.mass;
  limits.damping = device.damping;
  limits.quantum = device.quantum;
  haptics::TickParameters p;
  p.damping = 0.0;
  haptics::fitToDevice(limits, 0.0, p);
  p.stiffness = p.stiffnessLimit;
  return p;
}

TEST(ClosedLoop, AtTheDefaultsAHandRestsWithNoMoreThanTheQuantumOfTheSpring) {
  for (const double friction : {0.0, 0.05}) {
    for (const double damping : {0.1, 0.5, 1.0}) {
      haptics::SimulatedDeviceParameters device;
      device.damping = damping;
      device.friction = friction;
      haptics::TickParameters p = defaultsFor(device);
      ASSERT_DOUBLE_EQ(p.stiffness, 1.5 * twoBOverT(damping));
      const Rest rest = handAtRest(p, device);
      EXPECT_LT(rest.way, 0.5 * kQuantum) << damping << ' ' << friction;
      EXPECT_LE(rest.force, 1.001 * p.stiffness * kQuantum) << damping << ' ' << friction;
      // The negative control: a reading of which the controller does not see that it is a mark's.
      EXPECT_GT(handAtRest(p, device, 1e-12).force, 2.0 * p.stiffness * kQuantum)
          << damping << ' ' << friction;
    }
  }
}

TEST(ClosedLoop, TheDampingOfASurfaceAddsNothingToWhatAHandAtRestFeels) {
  for (const bool controlled : {false, true}) {
    for (const double damping : {0.1, 0.5, 1.0}) {
      haptics::SimulatedDeviceParameters device;
      device.damping = damping;
      haptics::TickParameters p = defaultsFor(device);
      p.passivity = controlled;
      p.damping = 1.0;
      const Rest rest = handAtRest(p, device);
      EXPECT_LT(rest.way, 0.5 * kQuantum) << damping;
      EXPECT_LE(rest.force, 1.001 * p.stiffness * kQuantum) << damping;
      // The negative control: what the filtered difference makes of a quantum, damped.
      EXPECT_GT(handAtRest(p, device, 1e-12).force, p.stiffness * kQuantum + 0.01) << damping;
    }
  }
}

TEST(ClosedLoop, NorDoTheDampingAndViscosityOfASurfaceOfMoreThanASpring) {
  const haptics::SimulatedDeviceParameters device;
  haptics::TickParameters p = defaultsFor(device);
  for (const double damping : {0.0, 1.0, 10.0}) {
    p.damping = damping;
    const Rest rest = handAtRest(p, device, 0.0, 10.0);
    EXPECT_LT(rest.way, 0.5 * kQuantum) << damping;
    EXPECT_LE(rest.force, 1.001 * p.stiffness * kQuantum) << damping;
    EXPECT_GT(handAtRest(p, device, 1e-12, 10.0).force, 5.0 * p.stiffness * kQuantum) << damping;
  }
}

TEST(ClosedLoop, ASurfaceThatStatesMoreDampingThanADeviceBearsComesToRestAndUnlimitedItHammers) {
  const haptics::SimulatedDeviceParameters device;
  haptics::TickParameters p = defaultsFor(device);
  p.damping = 200.0;
  const Rest limited = handAtRest(p, device);
  p.dampingLimit = 0.0;
  const Rest unlimited = handAtRest(p, device);
  EXPECT_LT(limited.way, 0.5 * kQuantum);
  EXPECT_LE(limited.force, 1.001 * p.stiffness * kQuantum);
  EXPECT_GT(unlimited.way, 2.0 * kQuantum);
  EXPECT_GT(unlimited.force, 3.0);
}

TEST(ClosedLoop, AtTheDefaultsABareDeviceStaysWithinAQuantumAndWithoutTheControllerNeverRests) {
  for (const double b : {0.1, 0.5, 1.0, 2.0}) {
    haptics::SimulatedDeviceParameters device;
    device.damping = b;
    const double k = defaultsFor(device).stiffness;
    EXPECT_LE(0.5 * run({k, b, kQuantum, true}, untilQuiet(b, 0.5)).swing, kQuantum) << b;
    EXPECT_GT(0.5 * run({k, b, kQuantum, false}).swing, 5.0 * kQuantum) << b;
  }
}

TEST(ClosedLoop, ThePassivityControllerKeepsTheWallFromCreatingEnergy) {
  for (const double b : {0.1, 0.5, 1.0, 2.0}) {
    const double k = 1.5 * twoBOverT(b);
    const double ofAQuantum = 0.5 * k * kQuantum * kQuantum;
    const Outcome with = run({k, b, kQuantum, true}), without = run({k, b, kQuantum, false});
    EXPECT_GT(without.created, 10.0 * with.created) << b;
    EXPECT_LT(with.created, 10.0 * ofAQuantum) << b;
  }
}

TEST(ClosedLoop, ThePassivityControllerIsSilentWhereTheDeviceIsPassive) {
  for (const double b : {0.1, 0.5, 1.0, 2.0}) {
    for (const double quantum : {0.0, kQuantum}) {
      EXPECT_FALSE(run({0.45 * twoBOverT(b), b, quantum, true}, 3.0).acted) << b;
      EXPECT_FALSE(run({0.95 * twoBOverT(b), b, quantum, true, 1.0}, 3.0).acted) << b;
    }
  }
}

}  // namespace
}  // namespace tandem::test
