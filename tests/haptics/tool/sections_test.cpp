// What sections cut away is not felt, and sections that move never kick the hand.

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/gtc/quaternion.hpp>

#include "haptics/tick_data.h"
#include "tests/haptics/hand_probe.h"
#include "tests/support/random_numbers.h"

namespace tandem::haptics {
namespace {

using test::HandProbe;
using test::SceneBuilder;

constexpr double kTop = 0.02, kBall = 0.003;  // m
constexpr double kKick = 0.3;                 // N in 20 ms
constexpr int kWindow = 20;                   // ticks

assets::Scene boxScene() {
  SceneBuilder b;
  b.addPart(test::boxMesh({0.08, 0.08, 2.0 * kTop}));
  return b.scene;
}

Section cutBefore(double x) { return {{-1.0, 0.0, 0.0}, -x}; }

glm::dvec3 forceOn(const HandProbe& hand) { return hand.out.hands[0].toHand.force; }
glm::dvec3 contactOf(HandProbe& hand) { return hand.state.data().tool.contactWrench().force; }

/// The largest change of a force within 20 ms.
class Changes {
 public:
  void note(const glm::dvec3& force) {
    forces_.push_back(force);
    const std::size_t from = forces_.size() > kWindow ? forces_.size() - 1 - kWindow : 0;
    for (std::size_t i = from; i < forces_.size(); ++i)
      most_ = std::max(most_, glm::length(force - forces_[i]));
  }
  double most() const { return most_; }

 private:
  std::vector<glm::dvec3> forces_;
  double most_ = 0.0;
};

/// Forces while a hand that is still presses and sections move.
struct Watched {
  Changes sent, contact;

  explicit Watched(HandProbe& hand) { tick(hand); }
  void tick(HandProbe& hand) {
    hand.at(hand.sample.worldFromDevice.position);
    sent.note(forceOn(hand));
    contact.note(contactOf(hand));
  }
};

TEST(Sections, CutASolidOpenToItsInnerWalls) {
  HandProbe hand(boxScene());
  hand.sections = {cutBefore(0.0)};
  hand.at({0.01, 0.0, 0.03});
  hand.to({0.01, 0.0, kTop - 0.001}, 1e-3);
  EXPECT_NEAR(forceOn(hand).z, 0.8, 1e-3) << "what is left is felt";
  hand.to({0.01, 0.0, 0.03}, 1e-3);
  hand.to({-0.01, 0.0, 0.03}, 1e-3);
  hand.to({-0.01, 0.0, 0.0}, 1e-3);
  EXPECT_EQ(hand.out.contactCount, 0) << "what is cut away is not";
  hand.to({0.03, 0.0, 0.0}, 1e-3);
  EXPECT_EQ(hand.out.contactCount, 0) << "nor is the cut surface";
  hand.to({0.041, 0.0, 0.0}, 1e-3);
  EXPECT_NEAR(forceOn(hand).x, -0.8, 1e-3) << "the far wall is felt from within";
  hand.to({0.03, 0.0, kTop + 0.001}, 1e-3);
  EXPECT_NEAR(forceOn(hand).z, -0.8, 1e-3) << "the top too";
}

TEST(Sections, BallRollsOffTheEdgeOfACut) {
  test::HandProbe hand(boxScene());
  hand.parameters.toolRadius = kBall;
  hand.sections = {cutBefore(0.0)};
  hand.at({0.01, 0.002, 0.03});
  hand.to({0.01, 0.002, kTop + kBall - 0.002}, 1e-3);
  for (double x = 0.01; x > -0.0025; x -= 1e-4) {
    hand.at({x, 0.002, kTop + kBall - 0.002});
    const glm::dvec3 proxy = hand.out.worldFromProxy.position;
    // The ball lies on the face, or on the edge where the face ends.
    const double beyond = std::max(0.0, -proxy.x);
    EXPECT_NEAR(std::hypot(beyond, proxy.z - kTop), kBall, 1e-6) << x;
  }
  hand.at({-kBall - 1e-4, 0.002, kTop});
  EXPECT_EQ(hand.out.contactCount, 0) << "beside the edge there is nothing";
}

TEST(Sections, FaceInThePlaneOfASectionIsLeft) {
  HandProbe hand(boxScene());
  hand.sections = {{{0.0, 0.0, 1.0}, kTop}};
  hand.at({0.01, 0.0, 0.03});
  hand.to({0.01, 0.0, kTop - 0.001}, 1e-3);
  EXPECT_NEAR(forceOn(hand).z, 0.8, 1e-3);
}

TEST(Sections, NoneLeaveEveryBitAsItWas) {
  HandProbe with(boxScene()), without(boxScene());
  with.sections = {cutBefore(-0.2)};  // cuts nothing
  for (HandProbe* hand : {&with, &without}) {
    hand->parameters.toolRadius = kBall;
    hand->at({0.01, 0.0, 0.03});
    hand->to({0.039, 0.013, kTop + 0.001}, 1e-3);
    hand->to({0.045, 0.013, kTop - 0.001}, 1e-4);
  }
  EXPECT_EQ(forceOn(with), forceOn(without));
}

struct Passage {
  const char* name;
  double speed;  // m/s; 0: it jumps
  double radius;
};

class SectionPasses : public testing::TestWithParam<Passage> {
 protected:
  /// Moves the section along x, and waits until what fades has faded.
  void move(HandProbe& hand, double from, double to, Watched& watched) const {
    const double speed = GetParam().speed;
    const int ticks =
        speed > 0.0 ? static_cast<int>(std::ceil(std::abs(to - from) / (speed * hand.parameters.dt))) : 1;
    for (int i = 1; i <= ticks; ++i) {
      hand.sections = {cutBefore(glm::mix(from, to, static_cast<double>(i) / ticks))};
      watched.tick(hand);
    }
    for (int i = 0; i < 1000; ++i) watched.tick(hand);
  }
  TickParameters parameters() const {
    TickParameters p;
    p.toolRadius = GetParam().radius;
    return p;
  }
};

TEST_P(SectionPasses, ThePressedToolWithoutAKick) {
  const double radius = GetParam().radius, away = radius + 1e-3;
  for (const bool sphere : {false, true}) {
    SceneBuilder b;
    b.addPart(sphere ? test::sphereMesh(kTop, 24) : test::boxMesh({0.08, 0.08, 2.0 * kTop}));
    HandProbe hand(b.scene, parameters());
    hand.sections = {cutBefore(-away)};
    hand.at({1e-4, 2e-4, kTop + radius + 0.005});
    hand.to({1e-4, 2e-4, kTop + radius - 0.004}, 1e-4);
    ASSERT_GT(forceOn(hand).z, 3.0);
    Watched watched(hand);
    move(hand, -away, away, watched);
    EXPECT_EQ(forceOn(hand), glm::dvec3(0.0)) << "the surface is cut away";
    EXPECT_LE(watched.sent.most(), kKick);
    const bool slow = GetParam().speed > 0.0 && GetParam().speed < 0.05;
    if (!slow || radius == 0.0) {
      EXPECT_GT(watched.contact.most(), 1.0) << "the contact alone kicks";
    }
    Watched back(hand);
    move(hand, away, -0.2, back);
    EXPECT_LE(back.sent.most(), kKick);
    EXPECT_EQ(forceOn(hand), glm::dvec3(0.0)) << "what returns around the tool is not felt";
    EXPECT_TRUE(hand.out.flags & kFlagInside);
    hand.to({1e-4, 2e-4, kTop + radius + 0.005}, 1e-4);
    hand.to({1e-4, 2e-4, kTop + radius - 0.004}, 1e-4);
    EXPECT_GT(forceOn(hand).z, 3.0) << "and is felt again once it has been left";
  }
}

INSTANTIATE_TEST_SUITE_P(, SectionPasses,
                         testing::Values(Passage{"Point1mm", 1e-3, 0.0}, Passage{"Point100mm", 0.1, 0.0},
                                         Passage{"Point10m", 10.0, 0.0}, Passage{"PointJump", 0.0, 0.0},
                                         Passage{"Ball1mm", 1e-3, kBall}, Passage{"Ball100mm", 0.1, kBall},
                                         Passage{"Ball10m", 10.0, kBall}, Passage{"BallJump", 0.0, kBall}),
                         [](const auto& passage) { return passage.param.name; });

using Random = std::mt19937;

glm::dvec3 anyDirection(Random& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

/// Boxes and spheres that lie in and beside one another, around the origin.
assets::Scene anyScene(Random& random) {
  SceneBuilder b;
  for (int i = 0; i < 6; ++i) {
    const glm::dvec3 at = 0.015 * anyDirection(random), axis = anyDirection(random);
    const glm::dquat turn = glm::angleAxis(test::between(random, 0.0, 3.0), axis);
    const glm::dvec3 size(test::between(random, 0.01, 0.03), test::between(random, 0.01, 0.03),
                          test::between(random, 0.01, 0.03));
    b.addPart(i % 3 == 2 ? test::sphereMesh(0.5 * size.x, 12) : test::boxMesh(size), {at, turn});
  }
  return b.scene;
}

/// Sections that leave a box of `half` m around `centre`, in the axes of `turn`.
std::vector<Section> boxAround(const glm::dvec3& centre, const glm::dquat& turn, double half) {
  std::vector<Section> box;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      glm::dvec3 along(0.0);
      along[axis] = sign;
      along = turn * along;
      box.push_back({along, glm::dot(along, centre) + half});
    }
  }
  return box;
}

/// A hand that comes from afar and presses on whatever it meets first.
void press(HandProbe& hand, const glm::dvec3& from) {
  hand.at(0.06 * from);
  hand.to(-0.01 * from, 2e-4);
  hand.to(hand.out.worldFromProxy.position - 0.003 * from, 2e-4);
}

TEST(Sections, MoveInAnySceneWithoutAKick) {
  int kicked = 0, pressed = 0;
  double most = 0.0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Random random(seed);
    TickParameters parameters;
    parameters.toolRadius = seed % 2 == 0 ? 0.0 : 0.002;
    HandProbe hand(anyScene(random), parameters);
    press(hand, anyDirection(random));
    pressed += glm::length(forceOn(hand)) > 0.5 ? 1 : 0;
    const glm::dvec3 n = anyDirection(random);
    const double speed = std::pow(10.0, test::between(random, -2.0, 1.0));
    Watched watched(hand);
    for (int stroke = 0; stroke < 4; ++stroke) {
      const double from = stroke % 2 == 0 ? 0.06 : -0.06;
      const int ticks = std::max(1, static_cast<int>(0.12 / (speed * parameters.dt)));
      for (int i = 0; i <= ticks; ++i) {
        hand.sections = {{n, from * (1.0 - 2.0 * i / ticks)}};
        watched.tick(hand);
      }
    }
    most = std::max(most, watched.sent.most());
    EXPECT_LE(watched.sent.most(), kKick) << seed;
    kicked += watched.contact.most() > kKick ? 1 : 0;
  }
  EXPECT_GE(pressed, 10);
  EXPECT_GE(kicked, 10) << "contacts alone kick in most scenes";
  RecordProperty("mN", static_cast<int>(1000.0 * most));
}

TEST(Sections, BoxMovesInAnySceneWithoutAKick) {
  int kicked = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Random random(100 + seed);
    TickParameters parameters;
    parameters.toolRadius = seed % 2 == 0 ? 0.0 : 0.002;
    HandProbe hand(anyScene(random), parameters);
    press(hand, anyDirection(random));
    const glm::dquat turn = glm::angleAxis(test::between(random, 0.0, 3.0), anyDirection(random));
    const glm::dvec3 centre = hand.out.worldFromProxy.position + 0.005 * anyDirection(random);
    Watched watched(hand);
    for (int i = 0; i < 3000; ++i) {
      // Breathes, and jumps now and then.
      const double half = 0.012 * (1.0 + std::cos(0.006 * i)) - (i % 700 == 699 ? 0.01 : 0.0);
      hand.sections = boxAround(centre, turn, half);
      watched.tick(hand);
    }
    EXPECT_LE(watched.sent.most(), kKick) << seed;
    kicked += watched.contact.most() > kKick ? 1 : 0;
  }
  EXPECT_GE(kicked, 10);
}

TEST(Sections, AllowWhatTheHandsMotionExplains) {
  HandProbe hand(boxScene(), TickParameters{});
  hand.parameters.toolRadius = kBall;
  hand.parameters.damping = 0.0;
  hand.sections = {cutBefore(-0.03)};
  hand.at({0.0, 0.0, kTop + 0.01});
  hand.to({0.0, 0.0, kTop + kBall - 0.003}, 1e-4);
  constexpr double kTravel = 1e-4;  // m a tick, along the section's motion and back
  Changes changes;
  for (int i = 0; i < 2000; ++i) {
    hand.sections = {cutBefore(-0.03 + 1e-4 * (i < 1000 ? i : 2000 - i))};
    const double x = kTravel * ((i / 100) % 2 == 0 ? i % 100 : 100 - i % 100);
    hand.at({x, 0.0, kTop + kBall - 0.003});
    changes.note(forceOn(hand));
  }
  EXPECT_LE(changes.most(), kKick + hand.parameters.stiffness * kTravel * kWindow);
}

}  // namespace
}  // namespace tandem::haptics
