// A part in a hand that slips off what it pressed on: how fast it goes, and what the hand feels.

#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

#include "haptics/contact/grip_pace.h"
#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

using haptics::Displacement;
using haptics::GripPace;

/// Numbers between -1 and 1.
class Signed {
 public:
  explicit Signed(unsigned seed) : random_(seed) {}
  double next() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random_); }
  glm::dvec3 vector(double size) {
    const double x = next(), y = next(), z = next();
    return size * glm::dvec3(x, y, z);
  }

 private:
  std::mt19937 random_;
};

glm::dvec3 atGrip(const GripPace& pace, const Displacement& u) {
  return u.linear + glm::cross(u.angular, pace.arm);
}

TEST(GripPace, AllowsTheLargestShareWithinItsBounds) {
  Signed random(5);
  int cut = 0;
  for (int i = 0; i < 20'000; ++i) {
    GripPace pace;
    pace.arm = random.vector(0.1);
    pace.steady = random.vector(1e-4);
    pace.aside = 1e-4 * std::abs(random.next());
    pace.farthest = 2e-4 * std::abs(random.next());
    const double pushed = i % 2 == 0 ? 0.0 : 2e-5;
    const Displacement done{random.vector(3e-5), random.vector(3e-4)},
        next{random.vector(2e-4), random.vector(2e-3)};
    // By trial of 1,001 shares.
    const auto lastWithin = [&](const glm::dvec3& place, double radius) {
      const auto distance = [&](int thousandths) {
        return glm::distance(atGrip(pace, done) + 1e-3 * thousandths * atGrip(pace, next), place);
      };
      double least = 1e300;
      for (int k = 0; k <= 1000; ++k) least = std::min(least, distance(k));
      int last = 0;
      for (int k = 0; k <= 1000; ++k)
        if (distance(k) <= std::max(least, radius) + pushed) last = k;
      return 1e-3 * last;
    };
    const double most =
        std::min(lastWithin(glm::dvec3(0.0), pace.farthest), lastWithin(pace.steady, pace.aside));
    const double share = haptics::shareWithin(pace, done, next, pushed);
    ASSERT_NEAR(share, most, 2e-3) << i;
    cut += share < 1.0 ? 1 : 0;
  }
  EXPECT_GT(cut, 5'000);
}

TEST(GripPace, HoldsNoPartThatStandsStillAndNoneWithoutASpring) {
  EXPECT_EQ(haptics::shareWithin(GripPace{}, {}, {}, 0.0), 1.0);
  const GripPace loose = haptics::paceOf({}, 0.1);
  EXPECT_EQ(haptics::shareWithin(loose, {}, {glm::dvec3(1.0), glm::dvec3(1.0)}, 0.0), 1.0);
}

/// A cube stands on a block, and the hand leads it 6 mm below the block's top and over its edge at 40 mm/s.
PartCase overAnEdge(double scale, double off) {
  constexpr double kSpeed = 0.04, kBelow = 0.006;  // m/s and m
  const double size = 0.02 * scale, half = 0.5 * size;
  assets::Scene scene =
      sceneOfParts({{.name = "block",
                     .mesh = meshOf(boxSoup({size, size, size})),
                     .worldFromPart = {{0.0, 0.0, -half}, {1.0, 0.0, 0.0, 0.0}}},
                    {.name = "cube",
                     .mesh = meshOf(boxSoup({size, size, size})),
                     .worldFromPart = {{0.5 * half, off * half, half}, {1.0, 0.0, 0.0, 0.0}},
                     .movable = true,
                     .mass = 0.05}});
  const Pose start = scene.parts[1].worldFromPart;
  const double down = kBelow / kSpeed, across = 1.8 * size / kSpeed;
  const DevicePath led = [=](double time) {
    const double z = std::min(time, down) * kSpeed, x = std::max(time - down, 0.0) * kSpeed;
    return Pose{start.position + glm::dvec3(x, 0.0, -z), start.orientation};
  };
  return {"over an edge", std::move(scene), 1, led, down + across + 0.3, {}};
}

constexpr double kBegun = 0.02;  // s, by when the part has taken up the speed with which the hand begins

HeldPartRig slipOff(double scale, double off, double slipChange) {
  haptics::TickParameters parameters = rigParameters();
  parameters.slipChange = slipChange;
  return HeldPartRig(overAnEdge(scale, off), parameters);
}

TEST(Slips, AreGentleAtEveryScaleAndLeaveNoForce) {
  for (const double scale : {0.3, 1.0, 3.0})
    for (const double off : {0.0, 0.3, 0.6}) {
      HeldPartRig rig = slipOff(scale, off, haptics::TickParameters{}.slipChange);
      rig.run(0);
      expectSound(rig);
      const std::vector<double> changes = rig.forceSteps(kBegun);
      EXPECT_LE(quantile(changes, 1.0), 0.5 * kMostChange) << scale << ' ' << off;
      EXPECT_LE(quantile(changes, 0.99), kUsualChange) << scale << ' ' << off;
      EXPECT_LT(glm::length(rig.last().toHand.force), 0.01) << scale << ' ' << off;
    }
}

TEST(Slips, KickWithoutAPace) {
  HeldPartRig rig = slipOff(1.0, 0.3, 0.0);
  rig.run(0);
  EXPECT_GT(quantile(rig.forceSteps(kBegun), 1.0), 2.0 * kMostChange);
}

TEST(Slips, ArriveAtTheHandWithoutRinging) {
  HeldPartRig rig = slipOff(1.0, 0.3, haptics::TickParameters{}.slipChange);
  rig.run(0);
  double most = 0.0, beyond = 0.0;
  for (const RigTick& t : rig.ticks()) {
    most = std::max(most, t.toHand.force.z);
    beyond = std::max(beyond, -t.toHand.force.z);
  }
  EXPECT_GT(most, 5.0);
  EXPECT_LT(beyond, 0.25);
}

/// N a tick, the largest change of force as a hand that leads a cube at 100 mm/s meets a block and leaves it.
double hitChange(double slipChange) {
  constexpr double kSpeed = 0.1, kWay = 0.008;  // m/s and m
  PartCase hit = overAnEdge(1.0, 0.0);
  Pose start = hit.scene.parts[1].worldFromPart;
  start.position.z += 0.5 * kWay;
  hit.scene.parts[1].worldFromPart = start;
  hit.duration = 2.0 * kWay / kSpeed;
  hit.path = [=](double time) {
    const double down = std::min(kSpeed * time, 2.0 * kWay - kSpeed * time);
    return Pose{start.position - glm::dvec3(0.0, 0.0, down), start.orientation};
  };
  haptics::TickParameters parameters = rigParameters();
  parameters.slipChange = slipChange;
  HeldPartRig rig(std::move(hit), parameters);
  rig.run(0);
  EXPECT_GT(rig.mostForce(), 3.0);
  return quantile(rig.forceSteps(kBegun), 1.0);
}

TEST(Slips, AHandThatMeetsAWallFeelsItsSpring) {
  EXPECT_LE(hitChange(haptics::TickParameters{}.slipChange), 0.6 * kMostChange);
  EXPECT_GT(hitChange(0.0), 1.5 * kMostChange);
}

}  // namespace
}  // namespace tandem::test
