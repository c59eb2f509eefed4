// Two hands of one person at one site, tick by tick: what the second one asks for, takes, feels and leaves.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include <glm/geometric.hpp>

#include "client/hand/hand_loop.h"
#include "tests/client/hand/box_row.h"
#include "tests/support/allocation_counter.h"

namespace tandem::client {
namespace {

using sync::Micros;

constexpr SiteId kTwoHanded = 1, kAnother = 2;
constexpr PartId kBox = 0, kNext = 1;

/// Two hands over a row of movable boxes of 4 cm, on virtual time.
class SecondHandTest : public testing::Test {
 protected:
  SecondHandTest() {
    scene_ = test::rowOfBoxes();
    contact_ = std::make_unique<haptics::ContactScene>(scene_);
    exchange_ = std::make_unique<Exchange>();
    hand_ = std::make_unique<HandLoop>(*contact_, *exchange_);
    hand_->addSecondHand();
    exchange_->timeBase.write({1000000, 5000, kTwoHanded});
  }

  void tick(int count = 1) {
    for (int i = 0; i < count; ++i) {
      now_ += 1000;
      const haptics::DeviceSample second = sample(1);
      hand_->tick(sample(0), now_, &second);
      const glm::dvec3 force = felt().toHand.force;
      largestStep_ = std::max(largestStep_, glm::length(force - lastForce_));
      lastForce_ = force;
    }
  }

  haptics::DeviceSample sample(std::size_t hand) const {
    haptics::DeviceSample sample;
    sample.worldFromDevice = devices_[hand];
    sample.valid = true;
    sample.time = sync::toSeconds(now_);
    sample.buttons = buttons_[hand] ? 1u : 0u;
    return sample;
  }

  const haptics::TickOutput& out() const { return hand_->output().tick; }
  const haptics::HandFeedback& felt() const { return out().hands[1]; }

  void tell(NetworkEvent::Kind kind, SiteId owner, Epoch epoch, PartId part) {
    NetworkEvent event;
    event.kind = kind;
    event.record = {part, owner, epoch, hand_->worldFromPart(part)};
    ASSERT_TRUE(exchange_->events.push(event));
  }

  std::optional<HandIntent> intent() {
    HandIntent intent;
    return exchange_->intents.pop(intent) ? std::optional(intent) : std::nullopt;
  }

  /// The button of a hand goes down at a box; granted at once.
  void take(std::size_t hand, PartId part) {
    tick(5);
    buttons_[hand] = true;
    tick();
    const auto asked = intent();
    ASSERT_TRUE(asked.has_value());
    ASSERT_EQ(asked->part, part);
    tell(NetworkEvent::Kind::ownership, kTwoHanded, 1, part);
    tick(3);
  }

  /// Both at the first box: the second hand takes it from the side.
  void takeWithBoth() {
    take(0, kBox);
    devices_[1].position = {0.0205, 0.0, 0.0};
    tick(300);
    buttons_[1] = true;
    tick(3);
    ASSERT_EQ(out().hands[0].held, kBox);
    ASSERT_EQ(felt().held, kBox);
  }

  assets::Scene scene_;
  std::unique_ptr<haptics::ContactScene> contact_;
  std::unique_ptr<Exchange> exchange_;
  std::unique_ptr<HandLoop> hand_;
  Pose devices_[2] = {{{0.0, 0.0, 0.0205}, {1.0, 0.0, 0.0, 0.0}}, {{0.2, 0.0, 0.0205}, {1.0, 0.0, 0.0, 0.0}}};
  bool buttons_[2] = {};
  Micros now_ = 5000000;
  glm::dvec3 lastForce_{0.0, 0.0, 0.0};
  double largestStep_ = 0.0;
};

TEST_F(SecondHandTest, ItsToolIsShownWhereItIs) {
  EXPECT_FALSE(hand_->output().hands[1].present) << "before the first tick";
  devices_[1].position = {0.1, 0.0, 0.1};
  tick(5);
  const HandRecord& record = hand_->output().hands[1];
  EXPECT_TRUE(record.present);
  EXPECT_LT(glm::distance(record.worldFromProxy.position, devices_[1].position), 1e-9);
  EXPECT_EQ(record.contactCount, 0);
}

TEST_F(SecondHandTest, TakesWhatTheFirstHoldsWithoutAskingTheServer) {
  takeWithBoth();
  EXPECT_FALSE(intent().has_value());
  EXPECT_LT(largestStep_, 1e-6);
  for (int i = 0; i < 100; ++i) {
    devices_[1].position.x += 2e-5;
    tick();
  }
  tick(500);
  EXPECT_NEAR(felt().toHand.force.x, -0.8, 0.02);
  EXPECT_NEAR(out().hands[0].toHand.force.x, 0.8, 0.02);
}

TEST_F(SecondHandTest, AsksForAPartOfItsOwn) {
  take(0, kBox);
  take(1, kNext);
  EXPECT_EQ(out().hands[0].held, kBox);
  EXPECT_EQ(felt().held, kNext);
  for (int i = 0; i < 200; ++i) {
    devices_[1].position.x += 1e-4;
    tick();
  }
  tick(1000);
  EXPECT_NEAR(hand_->worldFromPart(kNext).position.x, 0.22, 1e-3);
  EXPECT_NEAR(hand_->worldFromPart(kBox).position.x, 0.0, 1e-6);
}

TEST_F(SecondHandTest, TakesAPartWithTheFirstOneIdle) {
  take(1, kNext);
  EXPECT_EQ(out().hands[0].held, kNoPart);
  EXPECT_EQ(felt().held, kNext);
}

TEST_F(SecondHandTest, WaitsForTheAnswerThatTheFirstHandWaitsFor) {
  devices_[1].position = {0.0205, 0.0, 0.0};
  tick(300);
  buttons_[0] = buttons_[1] = true;
  tick(5);
  ASSERT_TRUE(intent().has_value());
  EXPECT_FALSE(intent().has_value());  // one question
  tell(NetworkEvent::Kind::ownership, kTwoHanded, 1, kBox);
  tick(3);
  EXPECT_EQ(out().hands[0].held, kBox);
  EXPECT_EQ(felt().held, kBox);
}

TEST_F(SecondHandTest, ADenialLeavesBothIdle) {
  devices_[1].position = {0.0205, 0.0, 0.0};
  tick(300);
  buttons_[0] = buttons_[1] = true;
  tick(5);
  tell(NetworkEvent::Kind::denied, kAnother, 4, kBox);
  tell(NetworkEvent::Kind::ownership, kAnother, 4, kBox);
  tick(20);
  EXPECT_FALSE(hand_->output().grabPending);
  EXPECT_EQ(out().hands[0].held, kNoPart);
  EXPECT_EQ(felt().held, kNoPart);
}

TEST_F(SecondHandTest, ThePartStaysHereUntilBothHaveLetGo) {
  takeWithBoth();
  for (int i = 0; i < 100; ++i) {
    devices_[1].position.x += 2e-5;
    tick();
  }
  largestStep_ = 0.0;
  buttons_[0] = false;
  tick(1000);
  EXPECT_EQ(out().hands[0].held, kNoPart);
  EXPECT_EQ(felt().held, kBox);
  EXPECT_FALSE(intent().has_value());
  EXPECT_LT(largestStep_, 0.05);
  buttons_[1] = false;
  tick(1000);
  const auto released = intent();
  ASSERT_TRUE(released.has_value());
  EXPECT_EQ(released->kind, HandIntent::Kind::release);
  EXPECT_LT(largestStep_, 0.05);
}

TEST_F(SecondHandTest, APartThatIsTakenAwayLeavesBothHands) {
  takeWithBoth();
  tell(NetworkEvent::Kind::ownership, kNoSite, 2, kBox);
  tick(5);
  EXPECT_EQ(out().hands[0].held, kNoPart);
  EXPECT_EQ(felt().held, kNoPart);
}

TEST_F(SecondHandTest, ItsBareToolTouchesWhereTheFirstHandHoldsThePart) {
  take(0, kBox);
  for (int i = 0; i < 400; ++i) {  // lifted by 2 cm
    devices_[0].position.y += 5e-5;
    tick();
  }
  devices_[1].position = {0.03, 0.02, 0.0};
  tick(400);
  for (int i = 0; i < 120; ++i) {
    devices_[1].position.x -= 1e-4;
    tick();
  }
  tick(100);
  const double side = hand_->worldFromPart(kBox).position.x + 0.02;
  EXPECT_NEAR(felt().toHand.force.x, 800.0 * (side - 0.018), 0.05);
  // It takes it there: what it felt fades, and does not end at once.
  largestStep_ = 0.0;
  buttons_[1] = true;
  tick(600);
  EXPECT_EQ(felt().held, kBox);
  EXPECT_LT(largestStep_, 0.05);
  // Nor does a force come from where it lets go.
  buttons_[1] = false;
  tick(600);
  EXPECT_LT(glm::length(felt().toHand.force), 1e-6);
  EXPECT_LT(largestStep_, 0.05);
}

TEST_F(SecondHandTest, AfterAStallBothGraspsBeginAnewWithoutForce) {
  takeWithBoth();
  now_ += HandLoop::kStall + 5000;
  devices_[1].position.x += 0.03;
  tick();
  EXPECT_EQ(felt().toHand.force, glm::dvec3(0.0));
  tick(50);
  EXPECT_EQ(felt().held, kBox);
  EXPECT_LT(glm::length(felt().toHand.force), 1e-3);
}

TEST_F(SecondHandTest, AfterAStallItsBareToolIsPutOntoTheHand) {
  tick(5);
  now_ += 3 * sync::kSecond;
  devices_[1].position = {0.2, 0.0, 0.012};
  tick(300);
  EXPECT_EQ(largestStep_, 0.0);
}

TEST_F(SecondHandTest, WithoutAStallThatToolPressesFromAbove) {
  tick(5);
  devices_[1].position = {0.2, 0.0, 0.012};
  tick(300);
  EXPECT_GT(felt().toHand.force.z, 1.0);
}

TEST_F(SecondHandTest, TicksWithoutUsingTheHeap) {
  takeWithBoth();
  const test::AllocationScope scope;
  tick(300);
  buttons_[1] = false;
  tick(600);
  EXPECT_EQ(scope.count(), 0u);
}

}  // namespace
}  // namespace tandem::client
