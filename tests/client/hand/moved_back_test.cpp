// A part that the person wants back where it stood: the hand asks for it and releases it there, unless
// somebody has had it meanwhile.

#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include <glm/geometric.hpp>

#include "client/hand/hand_loop.h"
#include "tests/client/hand/box_row.h"

namespace tandem::client {
namespace {

constexpr SiteId kMover = 1;
constexpr PartId kMoved = 1;
const Pose kBack{{0.2, 0.3, 0.0}, {1.0, 0.0, 0.0, 0.0}};

/// A hand far from a row of boxes, on virtual time.
struct MovedBack : testing::Test {
  assets::Scene scene = test::rowOfBoxes();
  haptics::ContactScene contact{scene};
  std::unique_ptr<Exchange> exchange = std::make_unique<Exchange>();
  std::unique_ptr<HandLoop> hand;
  sync::Micros now = 5000000;
  double mostForce = 0.0;

  MovedBack() {
    exchange->settings.write({});
    hand = std::make_unique<HandLoop>(contact, *exchange);
    exchange->timeBase.write({1000000, 5000, kMover});
    ticks(5);
  }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) {
      now += 1000;
      haptics::DeviceSample sample;
      sample.worldFromDevice.position = {0.0, 1.0, 0.0};
      sample.valid = true;
      sample.time = sync::toSeconds(now);
      mostForce = std::max(mostForce, glm::length(hand->tick(sample, now).force));
    }
  }
  void tell(NetworkEvent::Kind kind, SiteId owner, Epoch epoch, const Pose& pose) {
    NetworkEvent event;
    event.kind = kind;
    event.record = {kMoved, owner, epoch, pose};
    ASSERT_TRUE(exchange->events.push(event));
  }
  std::optional<HandIntent> intent() {
    HandIntent intent;
    return exchange->intents.pop(intent) ? std::optional(intent) : std::nullopt;
  }
  /// The pose at which the box is released after it was granted in this epoch.
  Pose releasedAfterGrantIn(Epoch epoch) {
    tell(NetworkEvent::Kind::place, kNoSite, 3, kBack);
    ticks(2);
    const auto asked = intent();
    EXPECT_TRUE(asked && asked->kind == HandIntent::Kind::grab && asked->part == kMoved);
    tell(NetworkEvent::Kind::ownership, kMover, epoch, scene.parts[kMoved].worldFromPart);
    ticks(200);
    const auto released = intent();
    EXPECT_TRUE(released && released->kind == HandIntent::Kind::release && released->epoch == epoch);
    EXPECT_FALSE(intent().has_value());
    return released ? released->worldFromPart : Pose{};
  }
};

TEST_F(MovedBack, TheHandAsksForThePartAndReleasesItThere) {
  EXPECT_LT(glm::length(releasedAfterGrantIn(4).position - kBack.position), 1e-9);
  EXPECT_EQ(mostForce, 0.0) << "nothing is felt of it";
  EXPECT_EQ(hand->output().tick.hands[0].held, kNoPart);
}

TEST_F(MovedBack, WhatSomebodyHadMeanwhileStaysWhereItIs) {
  const glm::dvec3 stood = scene.parts[kMoved].worldFromPart.position;
  EXPECT_LT(glm::length(releasedAfterGrantIn(6).position - stood), 1e-9);
}

TEST_F(MovedBack, ADenialEndsIt) {
  tell(NetworkEvent::Kind::place, kNoSite, 3, kBack);
  ticks(2);
  ASSERT_TRUE(intent().has_value());
  tell(NetworkEvent::Kind::denied, 2, 4, kBack);
  ticks(500);
  EXPECT_FALSE(intent().has_value());
}

TEST_F(MovedBack, APartThatMayNotMoveIsNotAskedFor) {
  scene.parts[kMoved].movable = false;
  tell(NetworkEvent::Kind::place, kNoSite, 3, kBack);
  ticks(10);
  EXPECT_FALSE(intent().has_value());
}

}  // namespace
}  // namespace tandem::client
