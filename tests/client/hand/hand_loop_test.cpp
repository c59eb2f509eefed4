// The hand's side of a grasp, tick by tick: what it asks for, what it feels when the answer is yes, no, late
// or never.

#include "client/hand/hand_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include <glm/geometric.hpp>

#include "tests/client/hand/box_row.h"
#include "tests/support/allocation_counter.h"

namespace tandem::client {
namespace {

using sync::Micros;
using sync::PartRecord;

constexpr SiteId kSelf = 1, kOther = 2;
constexpr PartId kTheBox = 0;

/// A hand over a movable box of 4 cm, on virtual time.
class HandLoopTest : public testing::Test {
 protected:
  HandLoopTest() {
    scene_ = test::rowOfBoxes();
    contact_ = std::make_unique<haptics::ContactScene>(scene_);
    exchange_ = std::make_unique<Exchange>();
    hand_ = std::make_unique<HandLoop>(*contact_, *exchange_);
    exchange_->timeBase.write({1000000, 5000, kSelf});
  }

  Wrench tick(int count = 1) {
    Wrench wrench;
    for (int i = 0; i < count; ++i) {
      now_ += 1000;
      haptics::DeviceSample sample;
      sample.worldFromDevice = device_;
      sample.valid = true;
      sample.time = sync::toSeconds(now_);
      sample.buttons = button_ ? 1u : 0u;
      wrench = hand_->tick(sample, now_);
      largestStep_ = std::max(largestStep_, glm::length(wrench.force - lastForce_));
      lastForce_ = wrench.force;
    }
    return wrench;
  }

  void tell(NetworkEvent::Kind kind, SiteId owner, Epoch epoch, const Pose& pose, PartId part = kTheBox) {
    NetworkEvent event;
    event.kind = kind;
    event.record = {part, owner, epoch, pose};
    ASSERT_TRUE(exchange_->events.push(event));
  }

  std::optional<HandIntent> intent() {
    HandIntent intent;
    return exchange_->intents.pop(intent) ? std::optional(intent) : std::nullopt;
  }

  /// Button down at the box, granted at once.
  void take() {
    tick(5);
    button_ = true;
    tick();
    const auto asked = intent();
    ASSERT_TRUE(asked.has_value());
    ASSERT_EQ(asked->kind, HandIntent::Kind::grab);
    tell(NetworkEvent::Kind::ownership, kSelf, 1, scene_.parts[kTheBox].worldFromPart);
    tick(3);
    ASSERT_EQ(hand_->output().tick.hands[0].held, kTheBox);
  }

  assets::Scene scene_;
  std::unique_ptr<haptics::ContactScene> contact_;
  std::unique_ptr<Exchange> exchange_;
  std::unique_ptr<HandLoop> hand_;
  Pose device_{{0.0, 0.0, 0.0205}, {1.0, 0.0, 0.0, 0.0}};
  bool button_ = false;
  Micros now_ = 5000000;
  glm::dvec3 lastForce_{0.0, 0.0, 0.0};
  double largestStep_ = 0.0;
};

TEST_F(HandLoopTest, AsksOnceForTheTouchedPartAndFeelsNothingOfTheWait) {
  tick(5);
  button_ = true;
  tick(200);
  const auto asked = intent();
  ASSERT_TRUE(asked.has_value());
  EXPECT_EQ(asked->part, kTheBox);
  EXPECT_FALSE(intent().has_value());
  EXPECT_TRUE(hand_->output().grabPending);
  EXPECT_EQ(glm::length(lastForce_), 0.0);
}

TEST_F(HandLoopTest, WhatThePersonHasCutAwayIsNotFelt) {
  device_.position.z = 0.03;
  tick(5);
  device_.position.z = 0.019;
  ASSERT_GT(tick(5).force.z, 0.5);
  HandSettingsInput settings;
  settings.sections[0] = {{0.0, 0.0, 1.0}, 0.0};
  settings.sectionCount = 1;
  exchange_->settings.write(settings);
  tick(2000);
  EXPECT_EQ(lastForce_, glm::dvec3(0.0));
  EXPECT_EQ(hand_->output().tick.contactCount, 0);
}

TEST_F(HandLoopTest, WhilePartsAreShownElsewhereNothingIsFeltOrTaken) {
  take();
  HandSettingsInput settings;
  settings.lifted = true;
  exchange_->settings.write(settings);
  tick();
  EXPECT_EQ(hand_->output().tick.hands[0].held, kNoPart) << "the hand lets go";
  tick(1000);
  const auto released = intent();
  ASSERT_TRUE(released.has_value());
  EXPECT_EQ(released->kind, HandIntent::Kind::release);
  tell(NetworkEvent::Kind::ownership, kNoSite, 2, scene_.parts[kTheBox].worldFromPart);
  button_ = false;
  tick(5);
  button_ = true;
  device_.position.z = 0.0;
  tick(200);
  EXPECT_FALSE(intent().has_value());
  EXPECT_EQ(lastForce_, glm::dvec3(0.0));
  EXPECT_EQ(hand_->output().tick.touched, kNoPart);

  settings.lifted = false;
  exchange_->settings.write(settings);
  tick(200);
  EXPECT_FALSE(intent().has_value()) << "the button went down before";
  EXPECT_EQ(lastForce_, glm::dvec3(0.0)) << "the tool stands inside of the part";
  button_ = false;
  tick(5);
  button_ = true;
  tick(5);
  const auto asked = intent();
  ASSERT_TRUE(asked.has_value());
  EXPECT_EQ(asked->kind, HandIntent::Kind::grab);
}

TEST_F(HandLoopTest, APartThatThePersonPointsAtIsTakenFromWhereTheTipIsWithoutForce) {
  constexpr PartId kPointedAt = 1;
  tick(5);
  ASSERT_EQ(hand_->output().tick.touched, kTheBox);
  HandSettingsInput settings;
  settings.wish = kPointedAt;
  settings.graspButton = true;
  exchange_->settings.write(settings);
  tick();
  const auto asked = intent();
  ASSERT_TRUE(asked.has_value());
  ASSERT_EQ(asked->part, kPointedAt);
  tell(NetworkEvent::Kind::ownership, kSelf, 1, scene_.parts[kPointedAt].worldFromPart, kPointedAt);
  tick(50);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kPointedAt);
  EXPECT_LT(largestStep_, 1e-6);
}

TEST_F(HandLoopTest, AGrantBeginsWithoutForceAndThePartFollows) {
  take();
  EXPECT_LT(largestStep_, 1e-6);
  for (int i = 0; i < 400; ++i) {
    device_.position.x += 1e-4;
    tick();
  }
  tick(1500);
  EXPECT_NEAR(hand_->worldFromPart(kTheBox).position.x, 0.04, 1e-3);
}

TEST_F(HandLoopTest, ADenialLeavesTheHandIdleAndUnmoved) {
  tick(5);
  button_ = true;
  tick();
  tell(NetworkEvent::Kind::denied, kOther, 4, scene_.parts[kTheBox].worldFromPart);
  tell(NetworkEvent::Kind::ownership, kOther, 4, scene_.parts[kTheBox].worldFromPart);
  tick(300);
  EXPECT_FALSE(hand_->output().grabPending);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kNoPart);
  EXPECT_LT(largestStep_, 1e-9);
}

TEST_F(HandLoopTest, AGrantThatComesAfterTheButtonIsUpIsGivenBack) {
  tick(5);
  button_ = true;
  tick();
  ASSERT_TRUE(intent().has_value());
  button_ = false;
  tick(20);
  tell(NetworkEvent::Kind::ownership, kSelf, 3, scene_.parts[kTheBox].worldFromPart);
  tick(1000);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kNoPart);
  const auto back = intent();
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->kind, HandIntent::Kind::release);
  EXPECT_EQ(back->epoch, 3u);
}

TEST_F(HandLoopTest, AReleasedPartIsGivenBackOnceAtRestWhereItIs) {
  take();
  button_ = false;
  tick(1500);
  const auto back = intent();
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->kind, HandIntent::Kind::release);
  EXPECT_EQ(back->worldFromPart.position, hand_->worldFromPart(kTheBox).position);
  EXPECT_FALSE(intent().has_value());
  tell(NetworkEvent::Kind::ownership, kNoSite, 1, back->worldFromPart);
  tick(200);
  EXPECT_EQ(hand_->output().tick.ownedCount, 0);
}

TEST_F(HandLoopTest, ALostConnectionIsNoReasonToLetGo) {
  take();
  tell(NetworkEvent::Kind::lost, kNoSite, 0, {});
  tick(3000);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kTheBox);
  EXPECT_LT(largestStep_, 1e-6);
}

TEST_F(HandLoopTest, AGrabThatWasUnderWayWhenTheConnectionWentCanBeAskedAgain) {
  tick(5);
  button_ = true;
  tick();
  ASSERT_TRUE(intent().has_value());
  tell(NetworkEvent::Kind::lost, kNoSite, 0, {});
  button_ = false;
  tick(5);
  button_ = true;
  tick();
  EXPECT_TRUE(intent().has_value());
}

TEST_F(HandLoopTest, ATakenAwayPartFadesFromTheHand) {
  take();
  for (int i = 0; i < 30; ++i) {
    device_.position.x += 1e-4;
    tick();
  }
  largestStep_ = 0.0;
  const Pose elsewhere{{0.0, 0.1, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  tell(NetworkEvent::Kind::ownership, kNoSite, 2, elsewhere);
  tick(1000);
  EXPECT_FALSE(intent().has_value());
  EXPECT_EQ(hand_->output().tick.hands[0].held, kNoPart);
  EXPECT_NEAR(glm::length(hand_->worldFromPart(kTheBox).position - elsewhere.position), 0.0, 1e-6);
  EXPECT_LT(largestStep_, 0.4 + 1e-9);  // the slew limit of 400 N/s
  EXPECT_LT(glm::length(lastForce_), 1e-6);
}

TEST_F(HandLoopTest, APartThatAnotherSiteGotStaysInTheHandUntilThatIsDenied) {
  take();
  largestStep_ = 0.0;
  tell(NetworkEvent::Kind::ownership, kOther, 2, {{0.0, 0.1, 0.0}, {1.0, 0.0, 0.0, 0.0}});
  tick(100);
  const auto asked = intent();
  ASSERT_TRUE(asked.has_value());
  EXPECT_EQ(asked->kind, HandIntent::Kind::grab);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kTheBox);
  EXPECT_EQ(hand_->output().ownedEpoch[0], 0u) << "it would be published";
  EXPECT_LT(largestStep_, 1e-6);
  tell(NetworkEvent::Kind::denied, kOther, 2, {{0.0, 0.1, 0.0}, {1.0, 0.0, 0.0, 0.0}});
  tick(1000);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kNoPart);
  EXPECT_NEAR(hand_->worldFromPart(kTheBox).position.y, 0.1, 1e-6);
}

/// Another site owns the box; this hand's button is down on it, and the owner's link has begun.
class CoHolderHandTest : public HandLoopTest {
 protected:
  CoHolderHandTest() {
    tell(NetworkEvent::Kind::ownership, kOther, 4, scene_.parts[kTheBox].worldFromPart);
    tick(5);
    button_ = true;
    tick();
    EXPECT_EQ(intent()->kind, HandIntent::Kind::grab);
    link();
    tick(3);
  }
  void link() {
    NetworkEvent event;
    event.kind = NetworkEvent::Kind::link;
    event.ownedByPeer = true;
    event.link.id.part = kTheBox;
    event.link.id.peer = kOther;
    event.link.epoch = 77;
    event.link.delay = 0.02;
    ASSERT_TRUE(exchange_->events.push(event));
  }
  const haptics::OwnedPart& box() const { return hand_->output().tick.owned[0]; }
};

TEST_F(CoHolderHandTest, HoldsAReplicaThatItTiesAndDoesNotPublish) {
  EXPECT_EQ(hand_->output().tick.hands[0].held, kTheBox);
  EXPECT_EQ(hand_->output().ownedEpoch[0], 0u);
  EXPECT_EQ(box().links.count, 1);
  tick(20);
  haptics::AddressedPacket packet;
  ASSERT_TRUE(exchange_->linksOut.pop(packet));
  EXPECT_EQ(packet.link.peer, kOther);
  EXPECT_EQ(packet.packet.epoch, 77u);
  EXPECT_TRUE(packet.packet.on);
}

TEST_F(CoHolderHandTest, LeavesAWhileAfterItsHandIsOffAndFollowsFromWhereItIs) {
  tick(1600);  // the owner's packets do not come: its fingers wait for them for a second, then close
  for (int i = 0; i < 100; ++i) {
    device_.position.x += 1e-4;
    tick();
  }
  button_ = false;
  tick(static_cast<int>(HandLoop::kCoHolderStays / 1000) - 20);
  EXPECT_FALSE(intent().has_value());
  tick(40);
  ASSERT_TRUE(intent().has_value());
  EXPECT_EQ(hand_->output().tick.ownedCount, 0);
  const double left = hand_->worldFromPart(kTheBox).position.x;
  EXPECT_GT(left, 1e-3);
  NetworkEvent state;
  state.state = {kTheBox, 4, 1, scene_.parts[kTheBox].worldFromPart, {}};
  state.time = now_ + 1000000;
  ASSERT_TRUE(exchange_->events.push(state));
  double before = left, fastest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    tick();
    const double x = hand_->worldFromPart(kTheBox).position.x;
    fastest = std::max(fastest, std::abs(x - before));
    before = x;
  }
  EXPECT_NEAR(before, 0.0, 1e-4);
  EXPECT_LT(fastest, 0.1 * left) << "a step in a tick";
}

TEST_F(CoHolderHandTest, IsPassedThePartAsItIs) {
  largestStep_ = 0.0;
  tell(NetworkEvent::Kind::ownership, kSelf, 5, {{0.0, 0.3, 0.0}, {1.0, 0.0, 0.0, 0.0}});
  tick(50);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kTheBox);
  EXPECT_EQ(hand_->output().ownedEpoch[0], 5u);
  EXPECT_LT(std::abs(hand_->worldFromPart(kTheBox).position.y), 1e-3) << "its pose was set";
  EXPECT_LT(largestStep_, 1e-6);
}

TEST_F(CoHolderHandTest, GivesUpWhereNothingWantsThePartAnyMore) {
  button_ = false;
  tick(static_cast<int>(HandLoop::kCoHolderStays / 1000) + 20);
  ASSERT_EQ(intent()->kind, HandIntent::Kind::leave);
  link();  // a link that the owner begins anew meanwhile
  tick(3);
  ASSERT_TRUE(intent().has_value());
  EXPECT_EQ(hand_->output().tick.ownedCount, 0);
}

TEST_F(HandLoopTest, AnOwnerWhoseHandIsOffLeavesASharedPartToTheOthers) {
  take();
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::link;
  event.link.id.part = kTheBox;
  event.link.id.peer = kOther;
  event.link.epoch = 3;
  ASSERT_TRUE(exchange_->events.push(event));
  event.kind = NetworkEvent::Kind::simulators;
  event.simulators = 2;
  ASSERT_TRUE(exchange_->events.push(event));
  tick(100);
  EXPECT_EQ(hand_->output().tick.owned[0].links.count, 1);
  EXPECT_FALSE(intent().has_value());
  button_ = false;
  tick(2);
  const auto left = intent();
  ASSERT_TRUE(left.has_value());
  EXPECT_EQ(left->kind, HandIntent::Kind::release);
  EXPECT_EQ(hand_->output().ownedEpoch[0], 0u);
  tell(NetworkEvent::Kind::ownership, kOther, 2, left->worldFromPart);
  tick(3);
  EXPECT_EQ(hand_->output().tick.ownedCount, 0);
}

TEST_F(HandLoopTest, AfterAStallTheGraspBeginsAnewWithoutForce) {
  take();
  now_ += 3 * sync::kSecond;
  device_.position += glm::dvec3(0.05, 0.03, 0.0);  // the hand went on while the program stood still
  largestStep_ = 0.0;
  tick(500);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kTheBox);
  EXPECT_LT(largestStep_, 1e-3);
  EXPECT_EQ(hand_->output().stalls, 1u);
}

TEST_F(HandLoopTest, WithoutTheStallRuleThatHandWouldFeelAPull) {
  take();
  device_.position += glm::dvec3(0.05, 0.03, 0.0);  // the same jump without a gap in time
  largestStep_ = 0.0;
  tick(500);
  EXPECT_GT(largestStep_, 0.1);
}

class HandLoopStallTest : public HandLoopTest {
 protected:
  static constexpr Micros kNoGap = 0, kGap = 3 * sync::kSecond;

  /// After a gap the hand is 8 mm deep in the second box; returns the largest force from then on, N.
  double goIntoTheNextBox(Micros gap) {
    now_ += gap;
    device_.position = {0.2, 0.0, 0.012};
    double largest = 0.0;
    for (int i = 0; i < 500; ++i) largest = std::max(largest, glm::length(tick().force));
    return largest;
  }
};

TEST_F(HandLoopStallTest, ABareToolIsPutOntoTheHand) {
  tick(5);
  EXPECT_EQ(goIntoTheNextBox(kGap), 0.0);
  EXPECT_EQ(hand_->output().tick.worldFromProxy.position, device_.position);
}

TEST_F(HandLoopStallTest, SoIsThatOfAHandThatHoldsAPart) {
  take();
  EXPECT_LT(goIntoTheNextBox(kGap), 1e-3);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kTheBox);
}

TEST_F(HandLoopStallTest, SoIsThatOfAHandWhosePartWasGivenToAnotherMeanwhile) {
  take();
  tell(NetworkEvent::Kind::ownership, kNoSite, 2, scene_.parts[kTheBox].worldFromPart);
  EXPECT_LT(goIntoTheNextBox(kGap), 1e-3);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kNoPart);
}

TEST_F(HandLoopStallTest, SoIsThatOfAHandWhoseSolidPartWasGivenToAnotherMeanwhile) {
  ASSERT_TRUE(contact_->modelParts());
  hand_ = std::make_unique<HandLoop>(*contact_, *exchange_);
  take();
  tell(NetworkEvent::Kind::ownership, kNoSite, 2, scene_.parts[kTheBox].worldFromPart);
  EXPECT_LT(goIntoTheNextBox(kGap), 1e-3);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kNoPart);
}

TEST_F(HandLoopStallTest, WithoutAGapABareToolPressesOnTheBox) {
  tick(5);
  EXPECT_GT(goIntoTheNextBox(kNoGap), 1.0);
}

TEST_F(HandLoopStallTest, WithoutAGapTheToolOfAHandThatLosesItsPartPressesOnTheBox) {
  take();
  tell(NetworkEvent::Kind::ownership, kNoSite, 2, scene_.parts[kTheBox].worldFromPart);
  EXPECT_GT(goIntoTheNextBox(kNoGap), 1.0);
}

TEST_F(HandLoopStallTest, AHandThatStoodStillInItPressesOn) {
  tick(5);
  device_.position.z = 0.012;
  const double pressed = glm::length(tick(300).force);
  ASSERT_GT(pressed, 1.0);
  now_ += kGap;
  EXPECT_EQ(tick().force, glm::dvec3(0.0));
  EXPECT_NEAR(glm::length(tick(300).force), pressed, 1e-6);
}

TEST_F(HandLoopTest, ATipThatIsCaughtComesBackToTheDeviceWithoutForce) {
  tick(5);
  for (int i = 0; i < 600; ++i) {  // pushed through the box, the tip stays on the side where it came from
    device_.position.z -= 1e-4;
    tick();
  }
  ASSERT_GT(hand_->output().tick.worldFromProxy.position.z, 0.0199);
  HandSettingsInput settings;
  settings.reseats = 1;
  exchange_->settings.write(settings);
  tick(320);
  EXPECT_NEAR(hand_->output().tick.worldFromProxy.position.z, device_.position.z, 1e-9);
  EXPECT_EQ(glm::length(lastForce_), 0.0);
}

TEST_F(HandLoopTest, AFaultTakesTheForceUntilThePersonClearsIt) {
  for (int i = 0; i < 20; ++i) {
    device_.position.z -= 1e-4;
    tick();
  }
  device_.position.z = 0.019;
  tick(300);
  const double pressed = glm::length(lastForce_);
  ASSERT_GT(pressed, 0.3);
  Pose broken;
  broken.position.x = std::nan("");
  tell(NetworkEvent::Kind::ownership, kSelf, 1, broken, 2);  // taken as it is after the blend
  tick(600);
  EXPECT_STREQ(hand_->output().fault, "isValid(command.pose)");
  EXPECT_EQ(glm::length(lastForce_), 0.0);
  HandSettingsInput settings;
  settings.faultResets = 1;
  exchange_->settings.write(settings);
  tick(300);
  EXPECT_EQ(hand_->output().fault, nullptr);
  EXPECT_NEAR(glm::length(lastForce_), pressed, 1e-6);
}

TEST_F(HandLoopTest, PlaysOutWhatAnotherSiteMoves) {
  tell(NetworkEvent::Kind::ownership, kOther, 2, scene_.parts[1].worldFromPart, 1);
  std::uint32_t sequence = 0;
  for (int i = 0; i < 500; ++i) {
    if (i % 4 == 0) {
      NetworkEvent event;
      event.kind = NetworkEvent::Kind::state;
      event.time = now_ + 1000000;
      event.state.part = 1;
      event.state.epoch = 2;
      event.state.sequence = ++sequence;
      event.state.worldFromPart.position = {0.2, 1e-4 * i, 0.0};
      event.state.twist.linear = {0.0, 0.1, 0.0};
      ASSERT_TRUE(exchange_->events.push(event));
    }
    tick();
  }
  // 0.1 m/s, shown 5 ms late.
  EXPECT_NEAR(hand_->worldFromPart(1).position.y, 0.05 - 0.1 * 0.005, 2e-4);
}

TEST_F(HandLoopTest, WhatIsDrawnOfAPartThatComesToRestEndsWhereItIs) {
  const Pose rest{{0.2, 0.03, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  tell(NetworkEvent::Kind::ownership, kOther, 2, scene_.parts[1].worldFromPart, 1);
  tick(100);
  // All that was said of it meanwhile comes at once, as after a gap in the network: it has moved, and rests.
  tell(NetworkEvent::Kind::ownership, kNoSite, 2, rest, 1);
  tick(1000);
  std::optional<ShownPose> last;
  for (ShownPose shown; exchange_->shown.pop(shown);)
    if (shown.part == 1) last = shown;
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->worldFromPart.position, rest.position);
  EXPECT_EQ(last->worldFromDrawn.position, rest.position);
}

TEST_F(HandLoopTest, AFloodOfEventsLosesNone) {
  int sent = 0;
  for (Epoch epoch = 1; epoch <= 4000; ++epoch) {
    NetworkEvent event;
    event.kind = NetworkEvent::Kind::ownership;
    event.record = {static_cast<PartId>(epoch % 3),
                    kNoSite,
                    epoch,
                    {{0.2 * (epoch % 3), 1e-5 * epoch, 0.0}, {1, 0, 0, 0}}};
    while (!exchange_->events.push(event)) tick();
    ++sent;
  }
  tick(4000);
  for (PartId part = 0; part < 3; ++part)
    EXPECT_GT(hand_->worldFromPart(part).position.y, 1e-5 * 3996) << "the last word counts, part " << part;
}

TEST_F(HandLoopTest, TicksWithoutUsingTheHeap) {
  take();
  tick(10);
  const test::AllocationScope scope;
  tell(NetworkEvent::Kind::ownership, kOther, 2, scene_.parts[1].worldFromPart, 1);
  for (int i = 0; i < 300; ++i) {
    device_.position.x += 1e-4;
    tick();
  }
  button_ = false;
  tick(1000);
  EXPECT_EQ(scope.count(), 0u);
}

}  // namespace
}  // namespace tandem::client
