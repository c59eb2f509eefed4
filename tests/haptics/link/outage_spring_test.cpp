// What leads a replica while its link does not carry it. What two hands feel of it is in
// link_collision_test.cpp.

#include "haptics/link/outage_spring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace tandem::test {
namespace {

using haptics::OutageSpring;

constexpr double kSpringTick = 1e-3, kLever = 0.05;  // s, m
constexpr double kPartMass = 0.5;                    // kg

/// A replica on its spring, pushed by `push` N along x, and what its peer says of it.
class Led {
 public:
  Led() {
    body_.mass = kPartMass;
    body_.inertia = glm::dmat3(5e-4);
    peer.worldFromDrawn = body_.worldFromBody;
  }

  /// A tick; the peer goes on as it says, heard or not.
  void step(bool heard = true, bool wanted = true, bool held = false) {
    peer.worldFromDrawn = integrate(peer.worldFromDrawn, peer.twist, kSpringTick);
    peer.time += kSpringTick;
    if (heard) said_ = peer;
    spring.advance(body_.worldFromBody, body_.twist, {&said_, 0.0, delay, wanted, held}, kLever, kSpringTick);
    const haptics::Coupling coupling = spring.coupling(body_);
    const haptics::CoupledStep next =
        haptics::coupleBody(body_, {&coupling, 1}, {{push, 0.0, 0.0}, {}}, {}, kSpringTick);
    haptics::moveBody(body_, next.freeVelocity, next.freeSpin, kSpringTick);
    const Wrench back = next.couplings[0].onHand(next.freeVelocity, next.freeSpin);
    change = glm::length(back.force + force);
    force = -back.force;
  }
  void run(double seconds, bool heard = true, bool wanted = true, bool held = false) {
    for (int i = 0; i < std::lround(seconds / kSpringTick); ++i) step(heard, wanted, held);
  }
  double x() const { return body_.worldFromBody.position.x; }
  double behind() const { return glm::length(peer.worldFromDrawn.position - body_.worldFromBody.position); }

  haptics::LinkPacket peer;
  OutageSpring spring;
  double push = 0.0, delay = 0.03;  // N, s
  glm::dvec3 force{0.0};            // N, of the spring on the replica
  double change = 0.0;              // N, of it in the last tick

 private:
  haptics::RigidBody body_;
  haptics::LinkPacket said_;
};

TEST(OutageSpring, BeginsSlackWhereverItIsToLead) {
  Led led;
  led.peer.worldFromDrawn.position.x = 0.05;
  led.step();
  EXPECT_LT(glm::length(led.force), 0.05);
  led.run(2.0);
  EXPECT_LT(led.behind(), 1e-5);
}

TEST(OutageSpring, FollowsAPeerThatMoves) {
  Led led;
  double most = 0.0;
  for (int i = 0; i < 3000; ++i) {
    led.peer.twist.linear.x = 0.1 * std::sin(std::numbers::pi * 1e-3 * i);
    led.peer.twist.angular.y = 0.5 * std::sin(std::numbers::pi * 1e-3 * i);
    led.step();
    most = std::max(most, led.behind());
  }
  EXPECT_LT(most, 2e-3) << "m";
}

TEST(OutageSpring, WithoutNewsItsEndStandsStill) {
  Led led;
  led.peer.twist.linear.x = 0.1;
  led.run(1.0);
  const double then = led.x();
  led.run(1.0, false);
  EXPECT_LT(std::abs(led.x() - then), 0.01);
  EXPECT_GT(led.behind(), 0.08);
}

// An outage is over while something presses on the replica: the peer is elsewhere, and moves.
TEST(OutageSpring, WhatPressesOnTheReplicaFeelsNoJump) {
  Led led;
  led.run(0.2);
  led.push = 1.0;
  led.run(1.0, false);
  led.peer.worldFromDrawn.position.x = -0.02;
  led.peer.twist.linear.x = -0.05;
  double most = 0.0;
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 before = led.force;
    led.run(0.02);
    most = std::max(most, glm::length(led.force - before));
    if (led.x() < -0.03) led.peer.twist = Twist{};
  }
  EXPECT_LT(most, 0.3) << "N in 20 ms";
  EXPECT_NEAR(led.x() - led.peer.worldFromDrawn.position.x, 1.0 / 400.0, 1e-4) << "what it yields to 1 N";
}

TEST(OutageSpring, LetsGoSlowlyAndHoldsAgainWithoutAJump) {
  Led led;
  led.push = 1.0;
  led.run(1.0);
  double most = 0.0;
  for (int round = 0; round < 4; ++round) {
    for (int i = 0; i < 100; ++i) led.step(true, false), most = std::max(most, led.change);
    for (int i = 0; i < 300; ++i) led.step(true, true), most = std::max(most, led.change);
  }
  EXPECT_LT(most, 0.03) << "N in a tick";
  led.push = 0.0;
  led.run(1.0, true, false);
  EXPECT_FALSE(led.spring.share() > 0.0);
  EXPECT_EQ(led.force, glm::dvec3(0.0));
}

// A hand that takes the replica meanwhile is not dragged along by the spring, nor back.
TEST(OutageSpring, GoesAlongWithAHandThatTakesTheReplica) {
  Led led;
  led.push = 1.0;
  led.run(1.0);
  const double held = glm::length(led.force);
  led.push = 3.0;
  double most = 0.0;
  for (int i = 0; i < 600; ++i) led.step(true, true, true), most = std::max(most, glm::length(led.force));
  EXPECT_LE(most, held + 0.15);
  EXPECT_FALSE(led.spring.share() > 0.0);
}

}  // namespace
}  // namespace tandem::test
