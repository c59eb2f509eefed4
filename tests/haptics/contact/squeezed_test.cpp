// A part in the hand between two others that somebody else brings nearer to each other than it is wide.

#include <algorithm>

#include "tests/haptics/contact/moving_rig.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

constexpr double kHalf = 0.01;  // m, of the cube
constexpr double kSpeed = 0.2;  // m/s, of each jaw
constexpr PartId kCube = 0, kLower = 1, kUpper = 2;

/// A cube of 20 mm in the hand, and two plates that stand 5 mm under and over it.
class Vice {
 public:
  explicit Vice(bool withUpper) : rig(scene()), withUpper_(withUpper) {
    rig.ownAndGrasp(kCube, Pose{});
    rig.tick();
  }
  /// Brings the jaws together until `bite` m of the cube are in each, and lets them stand there for
  /// `seconds`.
  void close(double bite, double seconds) {
    const int ticks = static_cast<int>((kAway + bite) / (kSpeed * rig.parameters.dt));
    for (int i = 1; i <= ticks; ++i) put((kAway + bite) * i / ticks - kAway, kSpeed);
    put(bite, 0.0);
    rig.moved.clear();
    rig.tick(static_cast<int>(seconds / rig.parameters.dt));
  }
  /// How deep the cube is in the jaw that it is deepest in, m.
  double depth() const {
    const double y = rig.pose(kCube).position.y;
    const double lower = rig.pose(kLower).position.y + kHalf - (y - kHalf),
                 upper = y + kHalf - (rig.pose(kUpper).position.y - kHalf);
    return std::max(lower, upper);
  }
  MovingRig rig;

 private:
  static constexpr double kAway = 0.005;

  static assets::Scene scene() {
    const glm::dvec3 jaw(0.05, 2.0 * kHalf, 0.05);
    return sceneOfParts({{.name = "cube", .mesh = meshOf(boxSoup(glm::dvec3(2.0 * kHalf))), .movable = true},
                         {.name = "lower", .mesh = meshOf(boxSoup(jaw)), .worldFromPart = at(-1.0, -kAway)},
                         {.name = "upper", .mesh = meshOf(boxSoup(jaw)), .worldFromPart = at(1.0, -kAway)}});
  }
  static Pose at(double side, double bite) {
    return {{0.0, side * (2.0 * kHalf - bite), 0.0}, glm::dquat(1, 0, 0, 0)};
  }
  void put(double bite, double speed) {
    rig.moved = {{kLower, at(-1.0, bite), {{0.0, speed, 0.0}, glm::dvec3(0.0)}}};
    if (withUpper_) rig.moved.push_back({kUpper, at(1.0, bite), {{0.0, -speed, 0.0}, glm::dvec3(0.0)}});
    rig.tick();
  }

  bool withUpper_;
};

TEST(Squeezed, APartStaysWhereTheJawsMetIt) {
  for (const double bite : {5e-6, 2e-4, 2e-3}) {
    Vice vice(true);
    vice.close(bite, 0.2);
    double greatest = 0.0, drift = 0.0;
    const Pose before = vice.rig.pose(kCube);
    vice.rig.each = [&] {
      greatest = std::max(greatest, glm::length(vice.rig.out.hands[0].toHand.force));
      drift = std::max(drift, glm::length(vice.rig.pose(kCube).position - before.position));
    };
    vice.rig.tick(500);
    EXPECT_NE(vice.rig.flags & haptics::kFlagSqueezed, 0u);
    EXPECT_LT(vice.depth(), bite + 2e-6);
    EXPECT_LT(drift, 1e-6);
    EXPECT_LT(greatest, 0.05);
  }
}

TEST(Squeezed, AHandThatDragsAtItFeelsTheJawsAndNothingElse) {
  Vice vice(true);
  vice.close(1e-4, 0.2);
  // Up and aside by 4 mm and back: 4 N of 1 N/mm into the upper jaw, none along it.
  double greatest = 0.0, aside = 0.0, deepest = 0.0;
  vice.rig.each = [&] {
    greatest = std::max(greatest, std::abs(vice.rig.out.hands[0].toHand.force.y));
    aside = std::max(aside, std::abs(vice.rig.out.hands[0].toHand.force.x));
    deepest = std::max(deepest, vice.depth());
  };
  vice.rig.lead(
      [](double t) {
        const double displacement = 0.002 * (1.0 - std::cos(3.14159265 * t));
        return Pose{{displacement, displacement, 0.0}, glm::dquat(1, 0, 0, 0)};
      },
      2.0);
  EXPECT_NEAR(greatest, 4.0, 0.1);
  EXPECT_LT(aside, 0.2);
  EXPECT_LT(deepest, 1e-4 + 2e-6);
}

TEST(Squeezed, OneJawAlonePushesIt) {
  Vice vice(false);
  vice.close(2e-3, 0.2);
  EXPECT_EQ(vice.rig.flags & haptics::kFlagSqueezed, 0u);
  EXPECT_NEAR(vice.rig.pose(kCube).position.y, 2e-3, 5e-6);
  EXPECT_NEAR(vice.rig.out.hands[0].toHand.force.y, 2.0, 0.05);
}

}  // namespace
}  // namespace tandem::test
