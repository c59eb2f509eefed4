// A hand and the controls of a scene: what it asks for without the grasp button, and when it gives it back.

#include "client/hand/control_hand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>

#include "client/hand/hand_loop.h"
#include "tests/haptics/grasp/control_scenes.h"
#include "tests/support/allocation_counter.h"

namespace tandem::client {
namespace {

constexpr SiteId kHere = 1, kThere = 2;
constexpr PartId kButton = 0;

/// A point over the push button of buttonScene(1), on virtual time.
class ControlHandTest : public testing::Test {
 protected:
  ControlHandTest() : scene_(test::buttonScene(1.0).scene) {
    contact_ = std::make_unique<haptics::ContactScene>(scene_);
    exchange_ = std::make_unique<Exchange>();
    HandSettingsInput settings;
    settings.parameters[0].stiffness = 2000.0;
    exchange_->settings.write(settings);
    hand_ = std::make_unique<HandLoop>(*contact_, *exchange_);
    exchange_->timeBase.write({1000000, 5000, kHere});
    at(1e-3, 5);
  }

  /// The device at this height over the button, m, for so many ticks.
  void at(double height, int ticks = 1) {
    for (int i = 0; i < ticks; ++i) {
      now_ += 1000;
      haptics::DeviceSample sample;
      sample.worldFromDevice.position = {0.0, 0.0, height};
      sample.valid = true;
      sample.time = sync::toSeconds(now_);
      hand_->tick(sample, now_);
    }
  }

  void tell(NetworkEvent::Kind kind, SiteId owner, Epoch epoch) {
    NetworkEvent event;
    event.kind = kind;
    event.record = {kButton, owner, epoch, hand_->worldFromPart(kButton)};
    ASSERT_TRUE(exchange_->events.push(event));
  }

  std::optional<HandIntent> intent() {
    HandIntent intent;
    return exchange_->intents.pop(intent) ? std::optional(intent) : std::nullopt;
  }

  double value() const { return assets::controlValue(scene_.controls[0], hand_->worldFromPart(kButton)); }

  assets::Scene scene_;
  std::unique_ptr<haptics::ContactScene> contact_;
  std::unique_ptr<Exchange> exchange_;
  std::unique_ptr<HandLoop> hand_;
  sync::Micros now_ = 5000000;
};

TEST_F(ControlHandTest, PressingAsksOnceMovesItWhenGrantedAndGivesItBackAtRest) {
  at(-1e-3, 20);
  const auto asked = intent();
  ASSERT_TRUE(asked.has_value());
  EXPECT_EQ(asked->kind, HandIntent::Kind::grab);
  EXPECT_EQ(asked->part, kButton);
  EXPECT_FALSE(intent().has_value()) << "asked once";
  EXPECT_NEAR(value(), 0.0, 1e-12) << "rigid until it is granted";
  tell(NetworkEvent::Kind::ownership, kHere, 1);
  at(-1e-3, 100);
  EXPECT_GT(value(), 2e-4);
  EXPECT_EQ(hand_->output().tick.hands[0].held, kNoPart) << "nothing is grasped";
  at(-1e-3, 2000);
  EXPECT_FALSE(intent().has_value()) << "kept while it is pressed";
  at(5e-3, 1000);
  const auto released = intent();
  ASSERT_TRUE(released.has_value());
  EXPECT_EQ(released->kind, HandIntent::Kind::release);
  EXPECT_EQ(released->epoch, 1u);
  EXPECT_NEAR(assets::controlValue(scene_.controls[0], released->worldFromPart), 0.0, 1e-12);
  EXPECT_FALSE(intent().has_value());
}

TEST_F(ControlHandTest, ADenialHoldsUntilTheToolHasLeft) {
  at(-1e-3, 5);
  ASSERT_TRUE(intent().has_value());
  tell(NetworkEvent::Kind::denied, kThere, 3);
  at(-1e-3, 1000);
  EXPECT_FALSE(intent().has_value());
  at(1e-3, 5);
  at(-1e-3, 5);
  EXPECT_TRUE(intent().has_value());
}

TEST_F(ControlHandTest, OneThatIsTakenAwayIsNotAskedForUntilTheToolHasLeft) {
  at(-1e-3, 5);
  ASSERT_TRUE(intent().has_value());
  tell(NetworkEvent::Kind::ownership, kHere, 1);
  at(-1e-3, 50);
  tell(NetworkEvent::Kind::ownership, kNoSite, 1);
  at(-1e-3, 500);
  EXPECT_FALSE(intent().has_value());
  at(5e-3, 5);
  at(-1e-3, 5);
  EXPECT_TRUE(intent().has_value());
}

TEST_F(ControlHandTest, AfterALostConnectionItAsksAgain) {
  at(-1e-3, 5);
  ASSERT_TRUE(intent().has_value());
  tell(NetworkEvent::Kind::lost, kNoSite, 0);
  at(-1e-3, 5);
  EXPECT_TRUE(intent().has_value());
}

TEST_F(ControlHandTest, WhatOthersPressHardAgainstItsStopIsShownAtItsStop) {
  const assets::Control& button = scene_.controls[0];
  at(5e-3, 5);
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::ownership;
  event.record = {kButton, kThere, 1, hand_->worldFromPart(kButton)};
  ASSERT_TRUE(exchange_->events.push(event));
  const double speed = 0.2;  // m/s, up to the stop; then nothing arrives for a while
  double deepest = 0.0;
  for (int i = 0; i * 1e-3 * speed < button.max; ++i) {
    NetworkEvent moved;
    moved.kind = NetworkEvent::Kind::state;
    moved.time = now_ + 1000000;
    moved.state.part = kButton;
    moved.state.epoch = 1;
    moved.state.sequence = static_cast<std::uint32_t>(i + 1);
    moved.state.worldFromPart = assets::poseAt(button, i * 1e-3 * speed);
    moved.state.twist = assets::twistAt(button, moved.state.worldFromPart, speed);
    ASSERT_TRUE(exchange_->events.push(moved));
    at(5e-3);
    deepest = std::max(deepest, value());
  }
  for (int i = 0; i < 100; ++i) {
    at(5e-3);
    deepest = std::max(deepest, value());
    EXPECT_NEAR(
        glm::length(hand_->worldFromPart(kButton).position - assets::poseAt(button, value()).position), 0.0,
        1e-12);
  }
  EXPECT_NEAR(deepest, button.max, 1e-12);
}

TEST_F(ControlHandTest, AWishedValueIsOwnedSetAndGivenBack) {
  assets::Scene scene = test::buttonScene(1.0).scene;
  scene.controls[0].springStiffness = scene.controls[0].click.drop = 0.0;
  scene_ = scene;
  contact_ = std::make_unique<haptics::ContactScene>(scene_);
  hand_ = std::make_unique<HandLoop>(*contact_, *exchange_);
  hand_->setControl({kButton, 1.5e-3, 1});
  at(5e-3, 5);
  hand_->setControl({kButton, 1.5e-3, 1});  // the same wish: nothing new
  const auto asked = intent();
  ASSERT_TRUE(asked.has_value());
  EXPECT_EQ(asked->part, kButton);
  tell(NetworkEvent::Kind::ownership, kHere, 1);
  at(5e-3, 5);
  EXPECT_NEAR(value(), 1.5e-3, 1e-12);
  // While it is owned, another value needs no question; one beyond the stops is clamped.
  hand_->setControl({kButton, 1.0, 2});
  at(5e-3, 5);
  EXPECT_NEAR(value(), 2e-3, 1e-12);
  EXPECT_FALSE(intent().has_value());
  at(5e-3, 400);
  const auto released = intent();
  ASSERT_TRUE(released.has_value());
  EXPECT_EQ(released->kind, HandIntent::Kind::release);
  EXPECT_NEAR(assets::controlValue(scene_.controls[0], released->worldFromPart), 2e-3, 1e-12);
}

TEST_F(ControlHandTest, WhatIsNoControlOrNoNumberIsNotAskedFor) {
  hand_->setControl({7, 1e-3, 1});
  at(5e-3, 5);
  hand_->setControl({kButton, std::nan(""), 2});
  at(5e-3, 5);
  EXPECT_FALSE(intent().has_value());
}

TEST_F(ControlHandTest, TicksAllocateNothing) {
  at(-1e-3, 5);
  tell(NetworkEvent::Kind::ownership, kHere, 1);
  const test::AllocationScope scope;
  at(-1e-3, 200);
  at(5e-3, 500);
  EXPECT_EQ(scope.count(), 0u);
}

}  // namespace
}  // namespace tandem::client
