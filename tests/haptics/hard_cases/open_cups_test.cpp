// A hand that starts inside a part: it feels an open cup at once, or a flag says why it feels nothing.

#include <cmath>

#include "tests/haptics/hard_cases/hard_case.h"

namespace tandem::test {
namespace {

constexpr double kPastTheWall = 0.005;  // m: 4 N at 800 N/m

/// A cup around the z axis, open at the top, of one sheet of `sides` sides: a floor at z = 0, and a wall up
/// to `height` whose radius goes from `foot` to `mouth`.
struct Cup {
  const char* name;
  int sides;
  double foot, mouth, height;  // m
};

constexpr Cup kCups[] = {{"box", 4, 0.04, 0.04, 0.05},      {"glass", 24, 0.03, 0.035, 0.08},
                         {"bowl", 32, 0.01, 0.06, 0.04},    {"tray", 4, 0.06, 0.06, 0.01},
                         {"triangle", 3, 0.04, 0.05, 0.06}, {"tube", 16, 0.02, 0.02, 0.2},
                         {"bottle", 20, 0.05, 0.008, 0.06}};

/// `away`: the faces look away from the hand inside. `lid` closes it.
assets::Mesh cupMesh(const Cup& cup, bool away, bool lid = false) {
  ShapeBuilder b;
  const auto n = static_cast<std::uint32_t>(cup.sides);
  for (std::uint32_t i = 0; i < n; ++i) {
    const double angle = 2.0 * kPi * (i + 0.3) / n;
    b.vertex(cup.foot * std::cos(angle), cup.foot * std::sin(angle), 0.0);
    b.vertex(cup.mouth * std::cos(angle), cup.mouth * std::sin(angle), cup.height);
  }
  const auto triangle = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    if (away) return b.triangle(x, y, z);
    b.triangle(x, z, y);
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t low = 2 * i, high = low + 1, nextLow = 2 * ((i + 1) % n), nextHigh = nextLow + 1;
    triangle(low, nextLow, nextHigh);
    triangle(low, nextHigh, high);
    if (i > 0 && i + 1 < n) triangle(0, nextLow, low);
    if (lid && i > 0 && i + 1 < n) triangle(1, high, nextHigh);
  }
  return b.mesh();
}

/// Starts in the cup, at a share of its height, and presses 5 mm through the floor in one tick.
struct Start {
  Start(const assets::Mesh& mesh, const Cup& cup, double scale, double height) : hand(sceneOf(mesh), scale) {
    hand.at({0.001, 0.0007, height * cup.height});
    flagged = (hand.probe.out.flags & haptics::kFlagInside) != 0u;
    calm = glm::length(hand.force()) < 1e-9;
    force = hand.at({0.001, 0.0007, -kPastTheWall});
  }
  ScaledHand hand;
  bool flagged = false, calm = false;
  glm::dvec3 force{0.0};
};

TEST(OpenCups, AreFeltFromWithinOrAFlagSaysWhyNot) {
  for (const Cup& cup : kCups) {
    for (const double scale : kScales) {
      for (const bool away : {true, false}) {
        for (const double height : {0.2, 0.5, 0.9}) {
          SCOPED_TRACE(testing::Message()
                       << cup.name << " scale " << scale << " away " << away << " at " << height);
          const Start start(cupMesh(cup, away), cup, scale, height);
          EXPECT_TRUE(start.calm) << "force must not begin with a step";
          if (start.flagged) {
            EXPECT_TRUE(start.hand.probe.out.flags & haptics::kFlagInside);
            EXPECT_EQ(start.force, glm::dvec3(0.0));
          } else {
            EXPECT_NEAR(start.force.z, kStiffness * kPastTheWall, 1e-4);
          }
        }
      }
    }
  }
}

TEST(OpenCups, WhoseMouthIsWideAreFelt) {
  for (const Cup& cup : {kCups[0], kCups[1], kCups[2], kCups[3], kCups[4]}) {
    for (const double scale : kScales) {
      for (const double height : {0.5, 0.9}) {
        const Start start(cupMesh(cup, true), cup, scale, height);
        EXPECT_FALSE(start.flagged) << cup.name << " scale " << scale << " at " << height;
      }
    }
  }
}

/// With a lid it is a solid: nothing is felt until the hand has left it, and the flag says so all the time.
TEST(OpenCups, WithALidAreNotFeltUntilTheHandHasLeft) {
  for (const Cup& cup : kCups) {
    for (const double scale : kScales) {
      SCOPED_TRACE(testing::Message() << cup.name << " scale " << scale);
      Start start(cupMesh(cup, true, true), cup, scale, 0.5);
      EXPECT_TRUE(start.flagged);
      EXPECT_EQ(start.force, glm::dvec3(0.0));
      start.hand.at({0.001, 0.0007, -0.02});
      EXPECT_FALSE(start.hand.probe.out.flags & haptics::kFlagInside);
      EXPECT_NEAR(start.hand.at({0.001, 0.0007, kPastTheWall}).z, -kStiffness * kPastTheWall, 1e-4);
    }
  }
}

}  // namespace
}  // namespace tandem::test
