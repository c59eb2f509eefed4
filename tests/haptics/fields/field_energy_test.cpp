// What force fields do with energy: around loops, in a closed loop with a hand, and in the account of what a
// scene's own sources gave.

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "assets/scene/field_check.h"
#include "haptics/body/virtual_coupling.h"
#include "haptics/fields/force_fields.h"
#include "haptics/operator/simulated_hand.h"
#include "haptics/safety/passivity.h"
#include "tests/haptics/fields/field_samples.h"
#include "tests/haptics/hand_probe.h"
#include "tests/support/allocation_counter.h"

namespace tandem::haptics {
namespace {

using namespace test;

/// Net work and the sum of all absolute work of a field on a hand that goes once round a closed curve, J.
struct LoopWork {
  double net = 0.0, absolute = 0.0;
};

LoopWork workAround(const ForceField& field, const glm::dvec3& a, const glm::dvec3& b,
                    const glm::dvec3& centre, double speed = 0.2) {
  const FieldForce law(field);
  LoopWork work;
  constexpr int kSteps = 20'000;
  double at = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const auto place = [&](double s) {
      const double angle = 2.0 * kPi * s / kSteps;
      return centre + a * std::cos(angle) + b * std::sin(angle) + 0.2 * (a + b) * std::sin(3.0 * angle);
    };
    const glm::dvec3 step = place(i + 1.0) - place(i), middle = place(i + 0.5);
    if (law.path() != nullptr) at = i == 0 ? law.path()->nearest(middle) : law.path()->follow(middle, at);
    const FieldAction action = law.act({middle, glm::normalize(step) * speed, 0.0}, at);
    const double gained = glm::dot(action.stored + action.source + action.damping, step);
    work.net += gained;
    work.absolute += std::abs(gained);
  }
  return work;
}

const glm::dvec3 kA{0.05, 0.01, 0.0}, kB{0.0, 0.03, 0.04}, kCentre{0.01, 0.005, 0.0};

TEST(FieldEnergy, ConservativeFieldsGiveNothingAroundALoop) {
  const std::vector<ForceField> all = storedFields();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const LoopWork work = workAround(all[i], kA, kB, kCentre);
    EXPECT_GT(work.absolute, 1e-4) << i;  // the loop does go through the field
    EXPECT_LT(std::abs(work.net), 2e-4 * work.absolute) << i;
  }
}

TEST(FieldEnergy, DissipativeFieldsOnlyTake) {
  ForceField damper;
  damper.kind = Kind::damper;
  damper.damping = {1.0, 3.0, 0.0};
  ForceField viscosity = damper;
  viscosity.kind = Kind::viscosity;
  viscosity.region = box({0.03, 0.03, 0.03}, 0.01);
  ForceField guide = storedFields()[6];
  guide.damping.x = 2.0;
  for (const ForceField& field : {damper, viscosity, guide}) {
    EXPECT_EQ(assets::passivity(field), assets::Passivity::dissipative);
    EXPECT_LT(workAround(field, kA, kB, kCentre).net, -1e-5);
  }
}

TEST(FieldEnergy, ADriveAlongAClosedPathGivesItsForceTimesTheLength) {
  // The negative control: a force that goes round makes work without end, and the same measure shows it.
  ForceField guide;
  guide.kind = Kind::guide;
  guide.anchor = ForceField::Anchor::path;
  guide.closed = true;
  guide.stiffness = 200.0;
  guide.drive = 0.5;
  for (int i = 0; i < 32; ++i)
    guide.points.emplace_back(0.05 * std::cos(i * kPi / 16), 0.05 * std::sin(i * kPi / 16), 0.0);
  EXPECT_EQ(assets::passivity(guide), assets::Passivity::source);
  const FieldForce law(guide);
  double net = 0.0, at = 0.0;
  const int steps = 20'000;
  for (int i = 0; i < steps; ++i) {
    const auto place = [&](double s) {
      return 0.05 * glm::dvec3(std::cos(2 * kPi * s / steps), std::sin(2 * kPi * s / steps), 0.0);
    };
    at = law.path()->follow(place(i + 0.5), at);
    const FieldAction action = law.act({place(i + 0.5), glm::dvec3(0.0), 0.0}, at);
    net += glm::dot(action.stored + action.source, place(i + 1.0) - place(i));
  }
  EXPECT_NEAR(net, 0.5 * 2.0 * kPi * 0.05, 1e-3 * net);
}

TEST(FieldEnergy, AWindWithinABorderIsASourceAndIsCalledOne) {
  ForceField wind;
  wind.force = {0.0, 1.0, 0.0};
  wind.region = sphere(0.03, 0.01);
  EXPECT_EQ(assets::passivity(wind), assets::Passivity::source);
  // Up through the middle, back down outside.
  EXPECT_GT(std::abs(workAround(wind, {0.05, 0.0, 0.0}, {0.0, 0.06, 0.0}, {0.05, 0.0, 0.0}).net), 0.01);
}

TEST(FieldForce, ChangesWithoutAStepAcrossEveryBorder) {
  std::vector<ForceField> all = storedFields();
  ForceField wind;
  wind.force = {0.0, 1.0, 0.0};
  wind.region = box({0.03, 0.02, 0.03}, 0.01);
  all.push_back(wind);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> place(-0.07, 0.07);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const FieldForce law(all[i]);
    double step[2] = {0.0, 0.0};
    for (int line = 0; line < 4; ++line) {
      const glm::dvec3 from(place(random), place(random), place(random)), to = -from + glm::dvec3(0.003);
      for (int fine = 0; fine < 2; ++fine) {
        const int steps = fine == 0 ? 2000 : 8000;
        glm::dvec3 before(0.0);
        for (int k = 0; k <= steps; ++k) {
          const glm::dvec3 x = glm::mix(from, to, static_cast<double>(k) / steps);
          const FieldAction a =
              law.act({x, glm::dvec3(0.0), 0.0}, law.path() != nullptr ? law.path()->nearest(x) : 0.0);
          const glm::dvec3 force = a.stored + a.source;
          if (k > 0) step[fine] = std::max(step[fine], glm::distance(force, before));
          before = force;
        }
      }
    }
    // A quarter of the step, a quarter of the change: a jump would stay.
    EXPECT_LT(step[1], 0.35 * step[0] + 1e-9) << i;
    if (all[i].kind != Kind::constant || i + 1 == all.size()) {
      EXPECT_GT(step[0], 0.0) << i;
    }
  }
}

ForceField scaled(ForceField f, double s) {
  f.partFromField.position *= s;
  f.maxForce *= s;
  f.force *= s;
  f.region.halfSize *= s;
  f.region.radius *= s;
  f.region.fade *= s;
  for (glm::dvec3& p : f.points) p *= s;
  f.radius *= s;
  f.range *= s;
  f.fade *= s;
  f.strength *= s * s * s;
  f.depth *= s * s;
  f.sigma *= s;
  for (assets::PotentialTerm& t : f.terms)
    t.coefficient *= std::pow(s, 2.0 - (t.powers[0] + t.powers[1] + t.powers[2]));
  return f;
}

TEST(FieldForce, AScaledSceneGivesTheSameForcesScaled) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-0.06, 0.06);
  const std::vector<ForceField> all = storedFields();
  for (const double s : {1e-3, 20.0}) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      const ForceField larger = scaled(all[i], s);
      const FieldForce one(all[i]), other(larger);
      for (int n = 0; n < 50; ++n) {
        const glm::dvec3 x(place(random), place(random), place(random));
        const double at = one.path() != nullptr ? one.path()->nearest(x) : 0.0;
        const FieldAction a = one.act({x, glm::dvec3(0.0), 0.0}, at);
        const FieldAction b = other.act({x * s, glm::dvec3(0.0), 0.0},
                                        one.path() != nullptr ? other.path()->nearest(x * s) : 0.0);
        ASSERT_LT(glm::distance(a.stored * s, b.stored), 1e-9 * s * (1.0 + glm::length(a.stored)))
            << i << " at " << s;
      }
    }
  }
}

TEST(FieldForce, IsFiniteAndWithinItsMaximumWhateverThePlace) {
  std::vector<ForceField> all = storedFields();
  ForceField steep = all[12];
  steep.region = {};
  steep.terms = {{1e12, {4, 4, 4}}, {-1e12, {4, 3, 2}}};
  all.push_back(steep);
  all.push_back(gravity(1e12, 1e-12));
  ForceField wave;
  wave.kind = Kind::waveform;
  wave.force = {1.0, 0.0, 0.0};
  all.push_back(wave);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> exponent(-15.0, 11.0), sign(-1.0, 1.0);
  const auto wild = [&] { return std::copysign(std::pow(10.0, exponent(random)), sign(random)); };
  for (std::size_t i = 0; i < all.size(); ++i) {
    HandProbe probe(sceneWith({all[i]}));
    for (int n = 0; n < 200; ++n) {
      probe.sample.valid = true;
      probe.sample.worldFromDevice.position = {wild(), n % 5 == 0 ? 0.0 : wild(), wild()};
      probe.sample.twist.linear = {wild(), wild(), wild()};
      probe.sample.time = n % 7 == 0 ? std::numeric_limits<double>::quiet_NaN() : wild();
      const TickOutput& out = probe.tick();
      const double length = glm::length(out.hands[0].toHand.force);
      ASSERT_TRUE(length <= all[i].maxForce * (1.0 + 1e-9)) << i << ": " << length;
      ASSERT_EQ(out.flags & kFlagFault, 0u) << i;
    }
  }
}

/// A field with numbers from all over their ranges; of one in eight some lie beyond.
ForceField wildField(std::mt19937& random) {
  const double beyond = random() % 8 == 0 ? 1.0 : 0.0;
  const auto upTo = [&](double top) {  // of a power of ten
    std::uniform_real_distribution<double> exponent(-10.0, top + beyond);
    return random() % 6 == 0 ? 0.0 : std::pow(10.0, exponent(random));
  };
  const auto either = [&](double x) { return random() % 2 == 0 ? x : -x; };
  const auto length = [&] { return upTo(8.9); };
  const auto size = [&] { return upTo(2.9); };
  const auto any = [&] { return either(size()); };
  const auto place = [&] { return either(length()); };
  ForceField f;
  f.kind = static_cast<Kind>(random() % 8);
  f.anchor = static_cast<ForceField::Anchor>(random() % (f.kind == Kind::spring ? 4 : 3));
  if (f.kind == Kind::guide) f.anchor = ForceField::Anchor::path;
  f.potential = static_cast<ForceField::Potential>(random() % 3);
  f.maxForce = size();
  f.region = {
      static_cast<FieldRegion::Kind>(random() % 3), {length(), length(), length()}, length(), length()};
  f.force = {any(), any(), any()};
  f.waveform.kind = static_cast<assets::FieldWaveform::Kind>(random() % 4);
  f.waveform.width = size();
  f.stiffness = upTo(5.9);
  f.radius = length();
  f.range = length();
  f.fade = length();
  f.drive = any();
  f.damping = {size(), size(), size()};
  f.strength = either(upTo(11.9));
  f.depth = either(upTo(5.9));
  f.sigma = {length(), length(), length()};
  f.terms = {{either(upTo(11.9)), {4, 4, 4}}, {either(upTo(11.9)), {1, 0, 3}}};
  if (f.anchor == ForceField::Anchor::path)
    for (int i = 0; i < 4; ++i) f.points.emplace_back(place(), place(), place());
  f.closed = random() % 2 == 0;
  f.smooth = random() % 2 == 0;
  return f;
}

TEST(ForceFields, AnyFieldThatTheCheckLetsThroughGivesAFiniteForce) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> exponent(-12.0, 11.0);
  const auto wild = [&] {
    return std::copysign(std::pow(10.0, exponent(random)), random() % 2 == 0 ? 1.0 : -1.0);
  };
  int passed = 0;
  for (int round = 0; round < 4000; ++round) {
    const ForceField field = wildField(random);
    if (!assets::checkField(field, 0, "field").ok()) continue;
    ++passed;
    HandProbe probe(sceneWith({field}));
    for (int n = 0; n < 12; ++n) {
      probe.sample.valid = true;
      probe.sample.worldFromDevice.position = {wild(), n % 3 == 0 ? 0.0 : wild(), n % 4 == 0 ? 0.0 : wild()};
      probe.sample.twist.linear = {wild(), wild(), wild()};
      probe.sample.time = 1e-3 * n;
      const TickOutput& out = probe.tick();
      ASSERT_EQ(out.flags & kFlagFault, 0u) << round << " " << assets::nameOf(field.kind);
      ASSERT_TRUE(std::isfinite(out.sourcePower)) << round << " " << assets::nameOf(field.kind);
    }
  }
  EXPECT_GT(passed, 300);
}

// ---- with a hand in the loop ----

/// A device of 45 g that nobody holds, in one field; the largest excursion late and early, m, and what the
/// field gave beyond its own account, J.
struct FreeRun {
  double early = 0.0, late = 0.0, created = 0.0;
};

FreeRun letGoIn(const ForceField& field, double deviceDamping, double start, double kick, double dampingLimit,
                int delay = 0) {
  TickParameters parameters = springOnly();
  parameters.fieldDampingLimit = dampingLimit;
  HandProbe probe(sceneWith({field}), parameters);
  SimulatedDeviceParameters device;
  device.damping = deviceDamping;
  device.friction = 0.0;
  device.quantum = 0.0;
  device.forceMax = 1e9;
  Pose at;
  at.position.x = start;
  SimulatedHand hand({}, device, at);
  HandTarget target;
  target.holdsStylus = false;
  FreeRun run;
  double sources = 0.0;
  std::vector<glm::dvec3> line(static_cast<std::size_t>(delay), glm::dvec3(0.0));
  for (int i = 0; i < 4000; ++i) {
    probe.sample = hand.sample(1e-3 * i);
    probe.tick();
    sources += probe.out.sourcePower * 1e-3;
    const double given = hand.energyGiven();
    if (i > 20) run.created = std::max(run.created, given - sources);
    line.push_back(probe.out.hands[0].toHand.force);
    hand.step(target, line.front() + glm::dvec3(i < 5 ? kick : 0.0, 0.0, 0.0), 1e-3);
    line.erase(line.begin());
    const double x = std::abs(hand.devicePose().position.x), v = std::abs(hand.deviceVelocity().x);
    const double size = kick > 0.0 ? v : x;
    if (i >= 5 && i < 200) run.early = std::max(run.early, size);
    if (i >= 3800) run.late = std::max(run.late, size);
    if (!(size < 1e3)) {
      run.late = 1e9;
      break;
    }
  }
  return run;
}

TEST(FieldInTheLoop, ASpringBelowTheStiffestStableComesToRestAndOneAboveDoesNot) {
  for (const double damping : {0.1, 0.2, 0.5}) {
    // A held force gives out k T / 2 of damping; nothing else delays this loop.
    const double stiffest = 2.0 * damping / 1e-3;
    ForceField f = spring(0.8 * stiffest);
    f.maxForce = 1e6;
    const FreeRun below = letGoIn(f, damping, 1e-3, 0.0, 10.0);
    EXPECT_LT(below.late, 0.6 * below.early) << damping;
    f.stiffness = 1.5 * stiffest;
    const FreeRun above = letGoIn(f, damping, 1e-3, 0.0, 10.0);
    EXPECT_GT(above.late, 1.5 * above.early) << damping;
    // The account knows what the spring stored: only what sampling made is left over.
    EXPECT_GT(above.created, 0.3 * 0.5 * f.stiffness * above.early * above.early) << damping;
  }
}

TEST(FieldInTheLoop, DampersAreHeldToWhatAFreeDeviceBears) {
  ForceField f;
  f.kind = Kind::damper;
  f.damping = glm::dvec3(200.0);
  f.maxForce = 1e6;
  for (const int delay : {0, 1, 2}) {
    const FreeRun run = letGoIn(f, 0.1, 0.0, 1.0, TickParameters{}.fieldDampingLimit, delay);
    EXPECT_GT(run.early, 0.01) << delay;
    EXPECT_LT(run.late, 1e-4 * run.early) << delay;
  }
  EXPECT_GT(letGoIn(f, 0.1, 0.0, 1.0, 1e9).late, 1.0);  // the same damper unbounded tears itself apart
  f.damping = glm::dvec3(30.0);
  EXPECT_GT(letGoIn(f, 0.1, 0.0, 1.0, 1e9, 2).late, 1.0);  // with two ticks of delay, 30 N·s/m already do
}

// ---- the account ----

/// A hand among fields of every law, with what limits the force sent. Fails where the account leaves the
/// work, or where the fields gave less than `atLeast`, J.
void followTheAccount(double gain, double forceLimit, double atLeast) {
  assets::Scene scene = sceneWith(storedFields());
  ForceField wave;
  wave.kind = Kind::waveform;
  wave.force = {1.0, 0.5, 0.0};
  wave.waveform.frequency = 3.0;
  scene.fields.push_back(wave);
  scene.fields.push_back(gravity(1e-3, 0.02));
  scene.fields.back().part = 0;
  scene.parts.resize(1);
  scene.parts[0].movable = true;
  TickParameters parameters = springOnly();
  parameters.dt = 1e-4;  // so that the error of held forces is small
  parameters.gain = gain;
  parameters.forceLimit = forceLimit;
  HandProbe probe(std::move(scene), parameters);
  double given = 0.0, accounted = 0.0, largest = 0.0;
  glm::dvec3 force(0.0), before(0.0);
  for (int i = 0; i < 20'000; ++i) {
    const double t = i * parameters.dt;
    const glm::dvec3 x(0.05 * std::sin(7.0 * t), 0.04 * std::sin(5.0 * t + 1.0), 0.03 * std::cos(6.0 * t));
    Pose pose;
    pose.position = {0.05 * std::cos(4.0 * t), 0.0, 0.05 * std::sin(4.0 * t)};
    probe.moved.push_back(
        {0, pose, {{-0.2 * std::sin(4.0 * t), 0.0, 0.2 * std::cos(4.0 * t)}, glm::dvec3(0.0)}});
    const TickOutput& out = probe.at(x);
    if (i > 1) {
      given += glm::dot(0.5 * (force + out.hands[0].toHand.force), x - before);
      accounted += out.sourcePower * parameters.dt;
      largest = std::max(largest, std::abs(given));
    }
    force = out.hands[0].toHand.force;
    before = x;
    ASSERT_NEAR(given, accounted, 0.01 * largest + 1e-4) << t;
  }
  EXPECT_GT(largest, atLeast);
}

TEST(FieldEnergy, SourcePowerAccountsForWhatFieldsGive) { followTheAccount(1.0, 1e6, 0.05); }

TEST(FieldEnergy, SourcePowerCountsOnlyWhatTheLimitsLetThrough) {
  followTheAccount(0.25, 1e6, 0.02);
  // A potential whose force is cut short gives less than it loses, in the same proportion in both sums.
  followTheAccount(1.0, 1.0, 0.02);
}

TEST(FieldEnergy, NothingIsCountedWhileNoForceIsSent) {
  TickParameters parameters = springOnly();
  HandProbe probe(sceneWith({spring(100.0)}), parameters);
  for (int i = 0; i < 5; ++i) probe.at({0.01 - 1e-4 * i, 0.0, 0.0});
  EXPECT_GT(probe.out.sourcePower, 0.05);
  probe.parameters.zeroForce = true;
  probe.at({0.009, 0.0, 0.0});
  probe.at({0.008, 0.0, 0.0});
  EXPECT_EQ(probe.out.sourcePower, 0.0);
}

TEST(ForceFields, ATickWithEveryLawAllocatesNothing) {
  assets::Scene scene = sceneWith(storedFields());
  const ContactScene contact(scene, 1);
  const ContactWorld world(contact);
  ForceFields fields(scene);
  DeviceSample sample;
  sample.valid = true;
  const AllocationScope scope;
  for (int i = 0; i < 500; ++i) {
    sample.worldFromDevice.position = {0.1 * std::sin(0.1 * i), 0.05 * std::cos(0.07 * i), 0.0};
    static_cast<void>(fields.step(world, sample, 1e-3 * i, {}));
    if (i % 50 == 0) fields.forgetHand();
  }
  EXPECT_EQ(scope.count(), 0u);
}

TEST(ForceFields, AFieldComesAndGoesWithTheGraspOfItsOwnPart) {
  assets::Scene scene = sceneWith({spring(100.0)});
  scene.parts.resize(1);
  scene.fields[0].part = 0;
  const ContactScene contact(scene, 1);
  const ContactWorld world(contact);
  ForceFields fields(scene);
  DeviceSample sample;
  sample.valid = true;
  sample.worldFromDevice.position.x = -0.01;
  FieldSettings settings;
  EXPECT_NEAR(fields.step(world, sample, 0.0, settings).force.x, 1.0, 1e-12);
  settings.held = 0;
  double before = 1.0;
  for (int i = 0; i < 300; ++i) {
    const double now = fields.step(world, sample, 0.0, settings).force.x;
    EXPECT_LE(std::abs(now - before), 1.0 / 300.0 + 1e-9);
    before = now;
  }
  EXPECT_NEAR(before, 0.0, 1e-9);
  settings.held = kNoPart;
  for (int i = 0; i < 300; ++i) before = fields.step(world, sample, 0.0, settings).force.x;
  EXPECT_NEAR(before, 1.0, 1e-9);
}

}  // namespace
}  // namespace tandem::haptics
