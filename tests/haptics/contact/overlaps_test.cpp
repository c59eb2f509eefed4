// Parts that are in each other as the file has them: allowed where they were, and nowhere else.

#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

constexpr double kSunk = 0.2e-3;  // m

/// A bar of 80 mm over two towers of one part: sunk `kSunk` into the top of the left one (z = 0), `gap` above
/// the right one. The hand presses it 1 mm down, at the middle.
PartCase barOverTowers(double gap) {
  const glm::dquat straight(1.0, 0.0, 0.0, 0.0);
  const double low = -kSunk - gap;
  const auto tower = [](double x, double top) {
    return moved(boxSoup({0.02, 0.02, 0.04}), {x, 0.0, top - 0.02});
  };
  const Pose start{{0.0, 0.0, 0.005 - kSunk}, straight};
  assets::Scene scene =
      sceneOfParts({{.name = "towers", .mesh = meshOf(joined(tower(-0.028, 0.0), tower(0.028, low)))},
                    {.name = "bar",
                     .mesh = meshOf(boxSoup({0.08, 0.012, 0.01}, 2)),
                     .worldFromPart = start,
                     .movable = true}});
  const DevicePath path = [start](double time) {
    Pose pose = start;
    pose.position.z -= 1e-3 * std::clamp(time / 0.3, 0.0, 1.0);
    return pose;
  };
  return {"bar over towers", std::move(scene), 1, path, 0.6, {}};
}

/// The lowest point of the bar's underside over the right tower, m over that tower's top.
double overRightTower(const HeldPartRig& rig, double gap) {
  double least = 1e300;
  for (const double x : {0.018, 0.038})
    least = std::min(least, transformPoint(rig.last().part, {x, 0.0, -0.005}).z);
  return least + kSunk + gap;
}

TEST(Overlaps, AreAllowedWhereTheyWereAndNowhereElse) {
  const double gap = 0.1e-3;
  HeldPartRig rig(barOverTowers(gap));
  rig.run(0);
  EXPECT_GT(rig.mostForce(0.5), 0.3);  // it does press
  EXPECT_NEAR(overRightTower(rig, gap), 0.0, kSteadyDepth);
  // In the left one it is as deep as it was, and no deeper.
  double left = 1e300;
  for (const double x : {-0.038, -0.018})
    left = std::min(left, transformPoint(rig.last().part, {x, 0.0, -0.005}).z);
  EXPECT_NEAR(left, -kSunk, kSteadyDepth);
}

TEST(Overlaps, AreNotFeltWhileNothingPresses) {
  PartCase given = barOverTowers(0.1e-3);
  const Pose start = given.path(0.0);
  given.path = [start](double) { return start; };
  HeldPartRig rig(std::move(given));
  rig.run(0);
  EXPECT_LT(rig.mostForce(), 1e-3);
  EXPECT_LT(rig.finalOffset(start), 1e-6);
}

/// Drawn across the tower until it has left the place where it was sunk.
TEST(Overlaps, AreDrawnOutOfWithoutABlow) {
  PartCase given = barOverTowers(5e-3);
  const Pose start = given.path(0.0);
  given.duration = 1.0;
  given.path = [start](double time) {
    Pose pose = start;
    pose.position.y += 0.01 * (1.0 - std::cos(std::min(time / 0.8, 1.0) * 3.14159265358979));
    return pose;
  };
  HeldPartRig rig(std::move(given));
  rig.run(0);
  EXPECT_LT(quantile(rig.forceSteps(), 1.0), 0.1);  // N a tick
  EXPECT_LT(rig.mostForce(), 0.6);
  EXPECT_NEAR(rig.last().part.position.y, 0.02, 1e-4);
}

}  // namespace
}  // namespace tandem::test
