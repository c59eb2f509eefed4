// The grasp of one hand as a state machine, without a tick or a network.

#include "client/hand/grasp.h"

#include <gtest/gtest.h>

namespace tandem::client {
namespace {

using Stage = Grasp::Stage;
using Button = Grasp::Button;

constexpr PartId kPart = 3;

sync::PartRecord grantOf(PartId part) {
  sync::PartRecord record;
  record.part = part;
  record.epoch = 7;
  return record;
}

TEST(Grasp, ItsButtonHasEdges) {
  Grasp grasp;
  EXPECT_EQ(grasp.setButton(false), Button::unchanged);
  EXPECT_EQ(grasp.setButton(true), Button::pressed);
  EXPECT_EQ(grasp.setButton(true), Button::unchanged);
  EXPECT_TRUE(grasp.buttonIsDown());
  EXPECT_EQ(grasp.setButton(false), Button::lifted);
}

TEST(Grasp, GoesFromReachingByAskingAndTakingToHolding) {
  Grasp grasp;
  EXPECT_EQ(grasp.stage(), Stage::reaching);
  EXPECT_FALSE(grasp.isPending());
  grasp.setButton(true);
  grasp.ask(kPart);
  EXPECT_TRUE(grasp.is(Stage::asking, kPart));
  EXPECT_FALSE(grasp.is(Stage::asking, kPart + 1));
  EXPECT_TRUE(grasp.isPending());
  grasp.take(grantOf(kPart), 5000);
  EXPECT_TRUE(grasp.is(Stage::taking, kPart));
  EXPECT_TRUE(grasp.isPending());
  EXPECT_EQ(grasp.grant().epoch, 7u);
  EXPECT_EQ(grasp.takingUntil(), 5000);
  EXPECT_TRUE(grasp.hold(kPart));
  EXPECT_TRUE(grasp.is(Stage::holding, kPart));
  EXPECT_FALSE(grasp.isPending());
  grasp.end();
  EXPECT_EQ(grasp.stage(), Stage::reaching);
}

TEST(Grasp, HoldsAtOnceWhatIsHereAlready) {
  Grasp grasp;
  grasp.setButton(true);
  EXPECT_TRUE(grasp.hold(kPart));
  EXPECT_TRUE(grasp.is(Stage::holding, kPart));
}

TEST(Grasp, AButtonThatIsUpWhenThePartArrivesHoldsNothing) {
  Grasp grasp;
  grasp.setButton(true);
  grasp.ask(kPart);
  grasp.setButton(false);
  EXPECT_EQ(grasp.stage(), Stage::asking);  // the answer is still to come
  grasp.take(grantOf(kPart), 0);
  EXPECT_FALSE(grasp.hold(kPart));
  EXPECT_EQ(grasp.stage(), Stage::reaching);
}

TEST(Grasp, AGrantThatNobodyAskedForIsTakenByAFreeHand) {
  Grasp grasp;
  grasp.take(grantOf(kPart), 0);
  EXPECT_TRUE(grasp.is(Stage::taking, kPart));
  EXPECT_FALSE(grasp.hold(kPart));
}

TEST(GraspDeathTest, DoesNotAskOrTakeWhileItHolds) {
  Grasp grasp;
  grasp.setButton(true);
  grasp.hold(kPart);
  EXPECT_DEATH(grasp.ask(kPart), "");
  EXPECT_DEATH(grasp.take(grantOf(kPart), 0), "");
  EXPECT_DEATH(grasp.hold(kPart), "");
}

}  // namespace
}  // namespace tandem::client
