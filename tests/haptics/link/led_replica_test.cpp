// A replica that no hand holds yet is led to a peer that a hand moves, and the link takes it over. What leads
// it has no energy account, so the hand that moves the peer must get nothing of what it spends.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

#include "haptics/link/replica_links.h"
#include "tests/haptics/link/link_checks.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

using haptics::ReplicaLinks;

constexpr double kMass = 0.5;          // kg, of the part
constexpr double kMostGiven = 0.5e-3;  // J
constexpr double kFarthest = 0.012;    // m
constexpr double kBegins = 1.0;        // s: the link does
constexpr double kLasts = 4.0;         // s

/// A hand that moves the owner's replica whatever pulls at it: it comes to a speed, and stops at some time
/// after the link has begun.
struct Drag {
  Network network;
  double speed = 0.08;     // m/s
  double stops = 0.5;      // s, after the link has begun
  double stopping = 0.25;  // s, in which it does
  glm::dvec3 axis{1.0, 0.0, 0.0};
  unsigned seed = 1;

  glm::dvec3 velocity(double t) const {
    const double over = std::clamp((t - kBegins - stops) / stopping, 0.0, 1.0);
    return 0.5 * speed * (1.0 + std::cos(std::numbers::pi * over)) * std::min(1.0, t / 0.5) * axis;
  }
};

Drag drawn(unsigned seed) {
  std::mt19937 random(seed);
  const auto in = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Drag drag;
  drag.network.delay = in(0.005, 0.12);
  drag.network.loss = in(0.0, 0.05);
  drag.speed = in(0.02, 0.09);
  drag.stops = in(0.0, 1.2);
  drag.stopping = in(0.1, 0.5);
  drag.axis = glm::normalize(glm::dvec3(in(-1.0, 1.0), in(-1.0, 1.0), in(-1.0, 1.0)));
  drag.seed = seed;
  return drag;
}

haptics::LinkTerms termsOf(SiteId peer, double delay, bool led) {
  haptics::LinkTerms terms{{0, peer}, {}, delay, 1};
  terms.firstFadeTime = 0.25;
  terms.outageSpring = led;
  return terms;
}

/// One site's replica with its end of the link.
struct LedReplica {
  haptics::RigidBody body;
  ReplicaLinks links;
  double work = 0.0;  // J, of the link on it

  LedReplica() {
    body.mass = kMass;
    body.inertia = glm::dmat3(5e-4);
  }
  void account(const glm::dvec3& velocity, const glm::dvec3& spin, const Wrench& outagePull) {
    links.account(0, body, velocity, spin, outagePull);
    const Wrench pull = links.report(0).pull;
    work += kTick * (glm::dot(pull.force, velocity) + glm::dot(pull.torque, spin));
  }
  void carry(const glm::dvec3& velocity, double now) {
    body.twist = {velocity, {}};
    static_cast<void>(links.pull(0, body, {true, true}, now, kTick));
    haptics::moveBody(body, velocity, {}, kTick);
    account(velocity, {}, {});
  }
  /// Returns the work of what leads it, J.
  double follow(double now) {
    const haptics::LinkPull link = links.pull(0, body, {}, now, kTick);
    std::array<haptics::Coupling, 2> couplings{
        haptics::Coupling{{}, body.worldFromBody, {}, {0.0, link.damping, 0.0, link.rotDamping}}, {}};
    const haptics::OutageSpring* spring = links.outageSpring(0);
    if (spring != nullptr) couplings[1] = spring->coupling(body);
    const haptics::CoupledStep step =
        haptics::coupleBody(body, {couplings.data(), spring != nullptr ? 2u : 1u}, link.held, {}, kTick);
    haptics::moveBody(body, step.freeVelocity, step.freeSpin, kTick);
    const Wrench back =
        spring != nullptr ? step.couplings[1].onHand(step.freeVelocity, step.freeSpin) : Wrench{};
    account(step.freeVelocity, step.freeSpin, {-back.force, -back.torque});
    return -kTick * (glm::dot(back.force, step.freeVelocity) + glm::dot(back.torque, step.freeSpin));
  }
};

struct Figures {
  double given = 0.0;     // J, the most that the hand was ever given
  double led = 0.0;       // J, work of what leads the replica
  double farthest = 0.0;  // m, of the replicas from each other once the led one has been near
};

Figures run(const Drag& drag, bool knowsItIsLed = true) {
  LedReplica owner, led;
  LinkLine toLed(drag.network, 2 * drag.seed), toOwner(drag.network, 2 * drag.seed + 1);
  const auto exchange = [](double now, LinkLine& line, LedReplica& to) {
    line.deliver(now, [&](const haptics::LinkPacket& packet) { to.links.receive({{0, 0}, packet}); });
  };
  Figures figures;
  bool near = false;
  for (int i = 0; i < std::lround(kLasts / kTick); ++i) {
    const double now = i * kTick;
    const glm::dvec3 velocity = drag.velocity(now);
    if (!owner.links.any() && now >= kBegins) {
      EXPECT_TRUE(owner.links.begin(termsOf(0, drag.network.delay, false), owner.body));
      led.body = owner.body;
      led.body.worldFromBody.position -= drag.network.delay * velocity;
      haptics::LinkTerms terms = termsOf(0, drag.network.delay, true);
      if (!knowsItIsLed) terms.firstFadeTime = 0.0;
      EXPECT_TRUE(led.links.begin(terms, led.body));
      for (LedReplica* replica : {&owner, &led}) replica->links.setSimulators(0, 2);
    }
    if (!owner.links.any()) {
      haptics::moveBody(owner.body, velocity, {}, kTick);
      continue;
    }
    exchange(now, toOwner, owner);
    exchange(now, toLed, led);
    owner.carry(velocity, now);
    figures.led += led.follow(now);
    for (const auto& [from, line] : {std::pair{&owner, &toLed}, std::pair{&led, &toOwner}}) {
      std::array<haptics::AddressedPacket, 1> packet;
      if (from->links.drainPackets(packet) > 0) line->send(now, packet[0].packet);
    }
    figures.given = std::max(figures.given, owner.work);
    const double apart = glm::length(owner.body.worldFromBody.position - led.body.worldFromBody.position);
    near = near || apart < 2e-3;
    if (near) figures.farthest = std::max(figures.farthest, apart);
  }
  return figures;
}

TEST(LedReplica, WhatLeadsItGivesTheHandThatMovesItsPeerNothing) {
  double given = 0.0, led = 0.0, farthest = 0.0;
  for (unsigned seed = 1; seed <= static_cast<unsigned>(10 * seeds(6)); ++seed) {
    const Drag drag = drawn(seed);
    const Figures figures = run(drag);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << 1e3 * drag.network.delay << " ms, "
                                    << drag.speed << " m/s, stops after " << drag.stops << " s");
    EXPECT_LE(figures.given, kMostGiven);
    EXPECT_LE(figures.farthest, kFarthest);
    given = std::max(given, figures.given);
    led = std::max(led, figures.led);
    farthest = std::max(farthest, figures.farthest);
  }
  if (atFullSize())
    std::printf("led: hand given %.3f mJ, led with %.3f mJ, %.1f mm apart\n", 1e3 * given, 1e3 * led,
                1e3 * farthest);
}

// The control: an end that counts waves as soon as its peer does, while it is led.
TEST(LedReplica, OneThatFadesInAtOnceGivesTheHandWhatLeadsIt) {
  Drag drag;
  drag.network.delay = 0.1;
  EXPECT_GT(run(drag, false).given, 2.0 * kMostGiven);
}

}  // namespace
}  // namespace tandem::test
