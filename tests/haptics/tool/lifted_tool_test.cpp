// A tool that is lifted off the scene feels nothing; neither lifting it nor setting it down kicks the hand.

#include "haptics/lifted_tool.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/haptics/hand_probe.h"
#include "tests/support/shapes.h"

namespace tandem::haptics {
namespace {

using test::HandProbe;
using test::SceneBuilder;

constexpr double kBoxTop = 0.02;     // m, of the box
constexpr double kMostChange = 0.3;  // N in 20 ms
constexpr double kDeep = 0.004;      // m: a press of 3.2 N

assets::Scene flatBox() {
  SceneBuilder b;
  b.addPart(test::boxMesh({0.08, 0.08, 2.0 * kBoxTop}));
  return b.scene;
}

/// Ticks a hand that is still, and finds the largest change of its force within 20 ms.
struct Watch {
  std::vector<glm::dvec3> forces;
  double most = 0.0;

  void tick(HandProbe& hand, int count) {
    for (int i = 0; i < count; ++i) at(hand, hand.sample.worldFromDevice.position);
  }
  void at(HandProbe& hand, const glm::dvec3& place) {
    hand.at(place);
    forces.push_back(hand.out.hands[0].toHand.force);
    for (std::size_t back = 1; back <= 20 && back < forces.size(); ++back)
      most = std::max(most, glm::length(forces.back() - forces[forces.size() - 1 - back]));
  }
  double now() const { return glm::length(forces.back()); }
};

/// A hand that presses on the box from above.
HandProbe pressing() {
  HandProbe hand(flatBox());
  hand.at({0.01, 0.0, 0.03});
  hand.to({0.01, 0.0, kBoxTop - kDeep}, 1e-4);
  return hand;
}

TEST(LiftedTool, ForceFadesAndNothingIsFeltOrTouched) {
  HandProbe hand = pressing();
  ASSERT_EQ(hand.out.touched, 0);
  Watch watch;
  watch.tick(hand, 30);
  ASSERT_NEAR(watch.now(), 800.0 * kDeep, 1e-3);
  hand.lifted = true;
  watch.tick(hand, 1000);
  EXPECT_LE(watch.most, kMostChange);
  EXPECT_EQ(watch.now(), 0.0);
  for (double z = kBoxTop - kDeep; z > -0.03; z -= 2e-4) watch.at(hand, {0.01, 0.0, z});
  EXPECT_EQ(watch.now(), 0.0);
  EXPECT_EQ(hand.out.contactCount, 0);
  EXPECT_EQ(hand.out.touched, kNoPart);
  EXPECT_EQ(hand.out.worldFromProxy.position, hand.sample.worldFromDevice.position);
}

TEST(LiftedTool, AHandWithoutAReadingInsteadIsKicked) {
  HandProbe hand = pressing();
  Watch watch;
  watch.tick(hand, 30);
  hand.sample.valid = false;
  hand.tick();
  EXPECT_GT(glm::length(watch.forces.back() - hand.out.hands[0].toHand.force), kMostChange);
}

TEST(LiftedTool, SetDownInsideAPartItIsNotKickedAndFeelsThatPartOnceItHasLeft) {
  HandProbe hand = pressing();
  hand.lifted = true;
  Watch watch;
  watch.tick(hand, 600);
  for (double z = kBoxTop - kDeep; z > 0.01; z -= 1e-4) watch.at(hand, {0.01, 0.0, z});
  hand.lifted = false;
  watch.tick(hand, 500);
  EXPECT_EQ(watch.now(), 0.0);
  EXPECT_LE(watch.most, kMostChange);
  EXPECT_NE(hand.out.flags & kFlagInside, 0u);
  hand.to({0.01, 0.0, kBoxTop + 0.002}, 1e-4);
  hand.to({0.01, 0.0, kBoxTop - 0.001}, 1e-4);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 0.8, 1e-3);
}

TEST(LiftedTool, AToolThatStaysAtTheSurfaceInsteadKicks) {
  HandProbe hand = pressing();
  hand.parameters.zeroForce = true;
  Watch watch;
  watch.tick(hand, 600);
  for (double z = kBoxTop - kDeep; z > 0.01; z -= 1e-4) watch.at(hand, {0.01, 0.0, z});
  hand.parameters.zeroForce = false;
  watch.tick(hand, 500);
  EXPECT_GT(watch.most, kMostChange);
}

TEST(LiftedTool, LiftedAndSetDownAtOnceItDoesNotKick) {
  HandProbe hand = pressing();
  Watch watch;
  watch.tick(hand, 30);
  for (int i = 0; i < 40; ++i) {
    hand.lifted = !hand.lifted;
    watch.tick(hand, 7);
  }
  EXPECT_LE(watch.most, kMostChange);
}

TEST(LiftedTool, FieldsFadeAndComeBackSlowly) {
  assets::Scene scene = flatBox();
  assets::ForceField field;
  field.kind = assets::ForceField::Kind::constant;
  field.force = {2.0, 0.0, 0.0};
  scene.fields.push_back(field);
  HandProbe hand(std::move(scene));
  hand.at({0.0, 0.0, 0.1});
  Watch watch;
  watch.tick(hand, 1000);
  ASSERT_NEAR(watch.now(), 2.0, 1e-9);
  watch = {};
  for (const bool lifted : {true, false}) {
    hand.lifted = lifted;
    watch.tick(hand, 1000);
    EXPECT_NEAR(watch.now(), lifted ? 0.0 : 2.0, 1e-9);
  }
  EXPECT_LE(watch.most, kMostChange);
}

}  // namespace
}  // namespace tandem::haptics
