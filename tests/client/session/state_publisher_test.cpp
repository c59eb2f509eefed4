// When a site publishes its states: how far receivers extrapolate wrongly without an update, and how often
// updates leave.

#include "client/session/state_publisher.h"
#include "assets/base/constants.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <cmath>
#include <functional>

namespace tandem::client {
namespace {

using namespace sync;

assets::Scene oneSphere() {
  assets::Scene scene;
  scene.parts.resize(1);
  assets::ImplicitShape shape;
  shape.kind = assets::ImplicitShape::Kind::sphere;
  shape.radiusTop = shape.radiusBottom = 0.03;
  shape.height = 0.0;
  scene.parts[0].shapes = {shape};
  return scene;
}

struct Course {
  int updates = 0, withPresence = 0;
  double worst = 0.0;      // m, the error of a receiver that extrapolates and misses no update
  std::vector<Micros> at;  // when updates left
};

/// Asks every millisecond, as a site does; `part` gives the state at a time in s, or nothing where there is
/// none.
Course follow(const PublishRates& rates, double seconds, bool coHeld,
              const std::function<bool(double, PartState&)>& part,
              const std::function<void(double, Presence&)>& presence = {}) {
  StatePublisher publisher(oneSphere(), WireFrame{}, rates);
  Course course;
  std::vector<OfferedPart> offered;
  PartState sent;
  Micros sentAt = -1;
  for (Micros now = 0; now < static_cast<Micros>(seconds * 1e6); now += kMillisecond) {
    PartState state;
    state.part = 0;
    state.epoch = 1;
    offered.clear();
    if (part(toSeconds(now), state)) offered.push_back({state, coHeld});
    Presence here;
    if (presence) presence(toSeconds(now), here);
    bool newPresence = false;
    if (publisher.due(now, now, offered, here, newPresence)) {
      ++course.updates;
      course.withPresence += newPresence ? 1 : 0;
      course.at.push_back(now);
      sent = state;
      sentAt = now;
    }
    if (offered.empty() || sentAt < 0) continue;
    const Pose shown = integrate(sent.worldFromPart, sent.twist, toSeconds(now - sentAt));
    course.worst = std::max(course.worst, glm::length(shown.position - state.worldFromPart.position));
  }
  return course;
}

bool nothing(double, PartState&) { return false; }
bool resting(double, PartState&) { return true; }
bool steady(double t, PartState& state) {
  state.twist.linear.x = 0.2;
  state.worldFromPart.position.x = 0.2 * t;
  return true;
}
/// A motion of 5 mm to and fro, four times a second.
bool shaken(double t, PartState& state) {
  const double w = 2.0 * kPi * 4.0;
  state.twist.linear.x = 0.005 * w * std::cos(w * t);
  state.worldFromPart.position.x = 0.005 * std::sin(w * t);
  return true;
}

TEST(StatePublisher, AStillHandIsPublishedTwiceASecond) {
  const Course course = follow({}, 20.0, false, nothing);
  EXPECT_LE(course.updates, 50);
  EXPECT_GE(course.updates, 40);
  EXPECT_EQ(course.withPresence, course.updates);
  EXPECT_EQ(course.at[0], 0);
}

TEST(StatePublisher, APartAtRestIsPublishedEverLessOften) {
  const Course course = follow({}, 20.0, false, resting);
  EXPECT_LE(course.updates, 100) << "with those of the hand";
  ASSERT_GT(course.at.size(), 5u);
  EXPECT_LE(course.at[4], 80 * kMillisecond) << "several at once: one may get lost";
}

TEST(StatePublisher, WhatMovesEvenlyGoesAtTheLeastRate) {
  const Course course = follow({}, 10.0, false, steady);
  EXPECT_GE(course.updates, 600);
  EXPECT_LE(course.updates, 650);
  EXPECT_LT(course.worst, 1e-9);
}

TEST(StatePublisher, WhatIsShakenGoesMoreOftenAndIsShownWithinTheDeadband) {
  PublishRates rates;
  const Course course = follow(rates, 10.0, false, shaken);
  EXPECT_GT(course.updates, 700);
  EXPECT_LT(course.updates, 2300);
  EXPECT_LT(course.worst, 3e-4);
  rates.deadband = 0.02;
  const Course finer = follow(rates, 10.0, false, shaken);
  EXPECT_GT(finer.updates, course.updates);
  EXPECT_LT(finer.worst, course.worst);
  // Control: a larger tolerance gives a larger error.
  rates.deadband = 1.0;
  EXPECT_GT(follow(rates, 10.0, false, shaken).worst, 1.2 * course.worst);
}

TEST(StatePublisher, WhereAnotherHandIsOnItOrNothingIsToleratedEverythingGoes) {
  EXPECT_NEAR(follow({}, 10.0, true, steady).updates, 2500, 2);
  PublishRates exact;
  exact.deadband = 0.0;
  EXPECT_NEAR(follow(exact, 10.0, false, steady).updates, 2500, 2);
}

TEST(StatePublisher, TheEndOfAMotionIsPublishedAtOnce) {
  const double end = 1.0013;
  const Course course = follow({}, 2.0, false, [end](double t, PartState& state) {
    steady(std::min(t, end), state);
    if (t >= end) state.twist = {};
    return true;
  });
  int within = 0;
  for (const Micros at : course.at) within += at >= 1002 * kMillisecond && at <= 1006 * kMillisecond ? 1 : 0;
  EXPECT_GE(within, 1);
}

TEST(StatePublisher, AHandThatMovesIsPublishedAtItsRateAndATouchToo) {
  const Course moving = follow({}, 10.0, false, nothing,
                               [](double t, Presence& here) { here.worldFromTool.position.x = 0.1 * t; });
  EXPECT_NEAR(moving.withPresence, 600, 40);
  const Course trembling = follow({}, 10.0, false, nothing, [](double t, Presence& here) {
    here.worldFromTool.position.x = 5e-5 * std::sin(60.0 * t);
  });
  EXPECT_LE(trembling.withPresence, 30) << "nobody sees that";
  const Course touching = follow({}, 10.0, false, nothing,
                                 [](double t, Presence& here) { here.touched = t < 5.0 ? kNoPart : 0; });
  EXPECT_GT(std::count_if(touching.at.begin(), touching.at.end(),
                          [](Micros at) { return at >= 5 * kSecond && at < 5 * kSecond + 100000; }),
            3);
}

TEST(StatePublisher, ANewEpochIsPublishedAtOnce) {
  const Course course = follow({}, 2.0, false, [](double t, PartState& state) {
    if (t >= 1.0) state.epoch = 2;
    return true;
  });
  EXPECT_TRUE(std::any_of(course.at.begin(), course.at.end(),
                          [](Micros at) { return at >= kSecond && at < kSecond + 4 * kMillisecond; }));
}

}  // namespace
}  // namespace tandem::client
