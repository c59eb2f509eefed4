// An owner may say anything of its part: that it jumps, shakes, spins, or moves while it stands still. A hand
// that touches the part must not be kicked by it, and gets little energy from it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <string>

#include <glm/geometric.hpp>

#include "haptics/operator/simulated_hand.h"
#include "tests/haptics/hand_probe.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

constexpr double kLimit = 8.0;        // N/s, TickParameters::foreignSlewLimit of a session
constexpr double kStiffness = 800.0;  // N/m
constexpr int kTicks = 1500, kLieWindow = 20;
constexpr double kHalf = 0.03;  // m, half an edge of the part

enum class Lie { none, shake, slide, jumps, comes, creeps, spins, velocity };
enum class Doing { rests, presses, strokes };

constexpr Lie kLies[] = {Lie::shake,  Lie::slide, Lie::jumps,   Lie::comes,
                         Lie::creeps, Lie::spins, Lie::velocity};
constexpr Doing kDoings[] = {Doing::rests, Doing::presses, Doing::strokes};
const char* const kLieNames[] = {"none", "shake", "slide", "jumps", "comes", "creeps", "spins", "velocity"};
const char* const kDoingNames[] = {"rests", "presses", "strokes"};

glm::dvec3 direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

/// What the owner says of the part, one tick after the other.
class Liar {
 public:
  Liar(Lie lie, std::uint64_t seed) : lie_(lie), random_(seed), axis_(direction(random_)) {
    axis_.z = std::abs(axis_.z);
  }
  haptics::PartMotion say(int tick) {
    haptics::PartMotion motion{0, {}, {}};
    glm::dvec3& at = motion.worldFromPart.position;
    const double t = 1e-3 * tick;
    std::uniform_real_distribution<double> jump(-0.5, 0.5);
    switch (lie_) {
      case Lie::none:
        break;
      case Lie::shake:
        at = (tick / 2 % 2 == 0 ? 0.02 : -0.02) * axis_;
        break;
      case Lie::slide:
        at.x = 0.02 * std::sin(100.0 * t);
        motion.twist.linear.x = 2.0 * std::cos(100.0 * t);
        break;
      case Lie::jumps:
        if (tick % 50 == 0) jumped_ = {jump(random_) * axis_, fromRotationVector(3.0 * direction(random_))};
        motion.worldFromPart = tick % 100 < 50 ? jumped_ : Pose{};
        break;
      case Lie::comes:
        at.z = std::min(0.02, 0.3 * t);
        motion.twist.linear.z = 0.3;
        break;
      case Lie::creeps:
        at.z = 0.01 * t;
        motion.twist.linear.z = 0.01;
        break;
      case Lie::spins:
        motion.worldFromPart.orientation = fromRotationVector(30.0 * t * axis_);
        motion.twist.angular = 30.0 * axis_;
        break;
      case Lie::velocity:
        motion.twist.linear = (tick / 2 % 2 == 0 ? 5.0 : -5.0) * axis_;
        motion.twist.angular = 50.0 * axis_;
        break;
    }
    return motion;
  }

 private:
  Lie lie_;
  std::mt19937_64 random_;
  glm::dvec3 axis_;
  Pose jumped_;
};

struct Felt {
  double step = 0.0;    // N, greatest change of force within 20 ms
  double beyond = 0.0;  // N, the same less stiffness x path of the hand in that time
  double work = 0.0;    // J, most that the force gave the hand since the lie began

  void include(const Felt& other) {
    step = std::max(step, other.step);
    beyond = std::max(beyond, other.beyond);
    work = std::max(work, other.work);
  }
};

struct Setup {
  Lie lie = Lie::none;
  Doing doing = Doing::rests;
  double radius = 0.0, friction = 0.0;  // m, of the tool
  double limit = kLimit;                // N/s; 0: what the owner says is believed
  std::uint64_t seed = 1;
  bool holds = false;  // a cube, with which the hand touches the part instead of with its tool
};

constexpr double kCube = 0.01;  // m, an edge of the part in the hand

struct Touched {
  assets::Scene scene;
  haptics::ContactScene contact;

  Touched(double friction, bool withCube) : scene(sceneWith(friction, withCube)), contact(scene, 1) {
    if (withCube) contact.modelParts({});
  }

 private:
  static assets::Scene sceneWith(double friction, bool withCube) {
    SceneBuilder b;
    b.addPart(boxMesh(glm::dvec3(2.0 * kHalf)), {}, 1.0);
    Pose above;
    above.position = {0.004, 0.002, kHalf + 0.5 * kCube + 1e-3};
    if (withCube) b.addPart(boxMesh(glm::dvec3(kCube)), above, 0.2);
    b.scene.materials[0].staticFriction = b.scene.materials[0].dynamicFriction = friction;
    for (assets::Part& part : b.scene.parts) part.movable = true;
    return b.scene;
  }
};

/// Made once, for its models take long.
const Touched& touched(const Setup& setup) {
  static const Touched smooth(0.0, false), rough(0.5, false), smoothWithCube(0.0, true),
      roughWithCube(0.5, true);
  if (setup.holds) return setup.friction > 0.0 ? roughWithCube : smoothWithCube;
  return setup.friction > 0.0 ? rough : smooth;
}

/// A relaxed hand on a part whose owner begins to lie after a second.
class LiedTo {
 public:
  explicit LiedTo(const Setup& setup)
      : setup_(setup), touched_(touched(setup)), liar_(setup.lie, setup.seed) {
    parameters_.stiffness = parameters_.graspStiffness = kStiffness;
    parameters_.toolRadius = setup.radius;
    parameters_.foreignSlewLimit = setup.limit;
  }

  Felt run() {
    const haptics::ContactScene& contact = touched_.contact;
    haptics::TickState state(contact);
    for (int i = 0; i < kBefore + kTicks; ++i) {
      hand_.step(target(i), force_, 1e-3);
      if (i == kBefore) given_ = hand_.energyGiven();
      haptics::DeviceSample sample = hand_.sample(1e-3 * i);
      std::vector<haptics::PartMotion> moved;
      if (i >= kBefore) moved.push_back(liar_.say(i - kBefore));
      std::vector<haptics::PartCommand> commands;
      if (setup_.holds && i == 0) {
        commands.push_back({haptics::PartCommand::Kind::own, 1, touched_.scene.parts[1].worldFromPart});
        commands.push_back({haptics::PartCommand::Kind::grasp, 1, {}});
      }
      const haptics::TickInput input{.hands = {{{sample}}}, .moved = moved, .commands = commands};
      force_ = haptics::tick(input, contact, parameters_, state).hands[0].toHand.force;
      note(i);
    }
    return felt_;
  }

 private:
  static constexpr int kBefore = 1000;
  glm::dvec3 surface() const { return {0.004, 0.002, kHalf + (setup_.holds ? 0.5 * kCube : setup_.radius)}; }

  haptics::HandTarget target(int i) const {
    haptics::HandTarget target;
    target.worldFromTarget.position =
        surface() - glm::dvec3(0.0, 0.0, setup_.doing == Doing::presses ? 0.03 : 0.004);
    if (setup_.doing == Doing::strokes) target.worldFromTarget.position.x += 0.02 * std::sin(6e-3 * i);
    if (i < 200) target.worldFromTarget.position = surface() + glm::dvec3(0.0, 0.0, 1e-3);
    return target;
  }

  void note(int i) {
    forces_.push_back(force_);
    places_.push_back(hand_.devicePose().position);
    if (i < kBefore) return;
    double path = 0.0;
    for (int k = 0; k < kLieWindow; ++k) path += glm::length(places_.end()[-1 - k] - places_.end()[-2 - k]);
    const double step = glm::length(force_ - forces_.end()[-1 - kLieWindow]);
    felt_.include({step, step - kStiffness * path, hand_.energyGiven() - given_});
  }

  Setup setup_;
  const Touched& touched_;
  Liar liar_;
  haptics::TickParameters parameters_;
  haptics::SimulatedHand hand_{{}, {}, {surface() + glm::dvec3(0.0, 0.0, 1e-3), {1.0, 0.0, 0.0, 0.0}}};
  glm::dvec3 force_{0.0};
  std::vector<glm::dvec3> forces_, places_;
  double given_ = 0.0;
  Felt felt_;
};

/// The most that is felt of one lie, over tools, frictions and seeds.
Felt mostFelt(Lie lie, Doing doing, double limit, bool holds) {
  Felt most;
  const std::uint64_t seeds = atFullSize() ? 40 : 4;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    most.include(
        LiedTo({lie, doing, seed % 2 == 0 ? 0.003 : 0.0, seed % 4 < 2 ? 0.5 : 0.0, limit, seed, holds})
            .run());
  }
  const int l = static_cast<int>(lie), d = static_cast<int>(doing);
  std::printf("%-5s %-8s %-8s %.3f N in 20 ms, %6.3f N beyond the hand's own, %.2f mJ\n",
              holds ? "part" : "tool", kDoingNames[d], kLieNames[l], most.step, most.beyond, 1e3 * most.work);
  return most;
}

class LyingOwner : public testing::TestWithParam<bool> {};

TEST_P(LyingOwner, KicksNoHandThatTouchesItsPart) {
  for (const Lie lie : kLies) {
    for (const Doing doing : kDoings) {
      const Felt most = mostFelt(lie, doing, kLimit, GetParam());
      const std::string what =
          std::string(kLieNames[static_cast<int>(lie)]) + ", " + kDoingNames[static_cast<int>(doing)];
      EXPECT_LE(most.beyond, 0.3) << what;
      // A hand that strokes changes the force itself.
      if (doing != Doing::strokes) {
        EXPECT_LE(most.step, 0.3) << what;
      }
      EXPECT_LE(most.work, 10e-3) << what;
    }
  }
}

TEST_P(LyingOwner, KicksAHandThatBelievesIt) {
  const Felt most = mostFelt(Lie::comes, Doing::presses, 0.0, GetParam());
  EXPECT_GT(most.step, 1.0);
  EXPECT_GT(most.work, 20e-3);
}

INSTANTIATE_TEST_SUITE_P(WithToolOrPart, LyingOwner, testing::Bool());

/// A hand over the part, which feels its spring alone under the limit of a session.
HandProbe overPart() {
  SceneBuilder b;
  b.addPart(boxMesh(glm::dvec3(2.0 * kHalf)), {}, 1.0);
  haptics::TickParameters p = springOnly(kStiffness);
  p.foreignSlewLimit = kLimit;
  return HandProbe(b.scene, p);
}

TEST(HonestOwner, IsFeltAsItIsWhileItMovesSlowly) {
  // 5 mm/s towards a tool that stands still, and back.
  HandProbe probe = overPart();
  const glm::dvec3 tool(0.004, 0.002, kHalf + 0.0005);
  probe.at(tool);
  for (int i = 1; i <= 800; ++i) {
    const double way = 5e-6 * (i <= 400 ? i : 800 - i);
    probe.moved = {{0, {{0.0, 0.0, way}, {1.0, 0.0, 0.0, 0.0}}, {{0.0, 0.0, i <= 400 ? 5e-3 : -5e-3}, {}}}};
    const double depth = std::max(0.0, way - 0.0005);
    EXPECT_NEAR(probe.at(tool).hands[0].toHand.force.z, kStiffness * depth, 1e-3) << i;
  }
}

TEST(HonestOwner, IsFeltAgainOnceTheToolHasLeftAPartThatCameTooFast) {
  HandProbe probe = overPart();
  const glm::dvec3 tool(0.0, 0.0, kHalf + 0.005);
  probe.at(tool);
  for (int i = 1; i <= 20; ++i) {
    probe.moved = {{0, {{0.0, 0.0, 1e-3 * i}, {1.0, 0.0, 0.0, 0.0}}, {{0.0, 0.0, 1.0}, {}}}};
    EXPECT_LT(glm::length(probe.at(tool).hands[0].toHand.force), 0.01) << i;
  }
  EXPECT_NE(probe.out.flags & haptics::kFlagInside, 0u);
  probe.to({0.0, 0.0, kHalf + 0.03}, 1e-4);
  EXPECT_EQ(probe.out.flags & haptics::kFlagInside, 0u);
  EXPECT_NEAR(probe.to({0.0, 0.0, kHalf + 0.019}, 1e-4).hands[0].toHand.force.z, 0.8, 1e-3);
}

}  // namespace
}  // namespace tandem::test
