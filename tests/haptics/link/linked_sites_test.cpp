// Parts that two or three sites simulate with whole ticks, tied by links: what their hands feel of each other
// and of walls, and what a change of owner or the end of a link does to them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/base/minimum_jerk.h"
#include "haptics/measure/held_depth.h"
#include "haptics/tick_data.h"
#include "tests/haptics/link/link_checks.h"
#include "tests/haptics/link/linked_sites.h"
#include "tests/support/full_size.h"
#include "tests/support/part_cases.h"

namespace tandem::test {
namespace {

using haptics::minimumJerk;
using haptics::SixAxes;
using Kind = haptics::PartCommand::Kind;

constexpr double kQuantum =
    0.055;  // N: one of the device's through the grasp's spring, felt wherever a hand moves

LinkedSetup setupOf(double delay, const assets::Scene& scene, std::vector<BenchSite> sites) {
  LinkedSetup setup;
  setup.scene = scene;
  setup.sites = std::move(sites);
  setup.network.delay = delay;
  return setup;
}

/// Site 1 pulls away from the others.
SixAxes pullWay(double t, int site) {
  return site == 1 ? SixAxes{{0.015 * minimumJerk((t - 1.0) / 0.4), 0.0, 0.0}, {}} : SixAxes{};
}

/// N/m between the hands of sites 0 and 1, averaged from 4.5 to 6 s of a run.
template <typename Sites>
double handToHand(Sites& sites, const std::function<glm::dvec3()>& force) {
  double sum = 0.0, way = 0.0;
  const glm::dvec3 start = sites.site(1).arm.device().position - sites.site(0).arm.device().position;
  while (sites.time() < 6.0) {
    sites.step(pullWay);
    if (sites.time() < 4.5) continue;
    sum += glm::length(force());
    way += glm::length(sites.site(1).arm.device().position - sites.site(0).arm.device().position - start);
  }
  return sum / way;
}

TEST(LinkedSites, HandsFeelEachOtherAsOnTheBench) {
  const assets::Scene scene = benchScene();
  for (const double delay : {0.010, 0.025, 0.050, 0.100}) {
    LinkedSites sites(setupOf(delay, scene, twoHands(firmArm(), firmArm())));
    sites.linkAll();
    const double felt = handToHand(sites, [&] { return sites.site(0).onHand().force; });
    BenchSetup setup;
    setup.network.delay = delay;
    setup.sites = twoHands(firmArm(), firmArm());
    LinkBench bench(setup);
    const double ofBench = handToHand(bench, [&] { return bench.site(0).onHand.force; });
    if (atFullSize())
      std::printf("tied, hand to hand %3.0f ms: %3.0f N/m, bench %3.0f, %.4f mJ\n", 1e3 * delay, felt,
                  ofBench, 1e3 * sites.maxCreated);
    EXPECT_NEAR(felt, ofBench, 0.1 * ofBench) << delay;
    EXPECT_LE(sites.maxCreated, kEnergyBound) << delay;
    EXPECT_EQ(sites.allocations, 0u);
    EXPECT_EQ(sites.flags & (haptics::kFlagFault | haptics::kFlagOverflow), 0u);
  }
}

/// N/m that site 1 feels of a wall that stands 5 mm before the part, while site 0 holds on.
double feltWall(double delay, bool tied, double& created) {
  constexpr double kWall = 0.005, kForce = 2.0;  // m, N
  LinkedSites sites(setupOf(delay, benchScene(kWall), twoHands(lightArm(), firmArm())));
  if (tied) sites.linkAll();
  const double way = kWall + kForce / firmArm().stiffness;
  const auto intent = [&](double t, int site) {
    const double share = t < 5.0 ? minimumJerk((t - 1.0) / 2.0) : 1.0 - minimumJerk((t - 5.0) / 2.0);
    return site == 1 ? SixAxes{{way * share, 0.0, 0.0}, {}} : SixAxes{};
  };
  const double start = sites.site(1).arm.reading().position.x;
  double xx = 0.0, xf = 0.0;
  while (sites.time() < 7.5) {
    sites.step(intent);
    const haptics::TickOutput& out = sites.site(1).out;
    if (out.contactCount == 0 || out.contacts[0].force < 0.02) continue;
    const double in = sites.site(1).arm.reading().position.x - start - kWall;
    xx += in * in;
    xf -= in * out.hands[0].toHand.force.x;
  }
  created = sites.maxCreated;
  return xf / xx;
}

TEST(LinkedSites, WallIsAsStiffForTheCoHolderAtAQuarterOfASecond) {
  double created = 0.0;
  const double near = feltWall(1e-3, true, created);
  EXPECT_LE(created, kEnergyBound);
  EXPECT_GT(near, 830.0);
  for (const double delay : {0.050, 0.250}) {
    const double felt = feltWall(delay, true, created);
    if (atFullSize())
      std::printf("tied, wall %3.0f ms: %3.0f N/m, at 1 ms %3.0f, %.4f mJ\n", 1e3 * delay, felt, near,
                  1e3 * created);
    EXPECT_NEAR(felt, near, 0.05 * near) << delay;
    EXPECT_LE(created, kEnergyBound) << delay;
  }
}

/// Both sites hold the peg, the first one leads it down.
TEST(LinkedSites, PegGoesIntoItsBoreInTwoHandsFiftyMillisecondsApart) {
  const PartCase peg = pegCase({.settle = 1.2});
  LinkedSetup setup =
      setupOf(0.050, peg.scene, {{firmArm(), {0.0, 0.0, 0.012}}, {lightArm(), {0.003, 0.0, 0.0}}});
  setup.link.lever = 0.015;
  LinkedSites sites(setup);
  sites.linkAll();
  haptics::HeldPartDepthMeter meter(sites.contact(), 0);
  const Pose start = sites.site(0).arm.device(), partFromGrip = inverse(peg.path(0.0)) * start;
  const auto intent = [&](double t, int site) {
    if (site != 0) return SixAxes{};
    return haptics::displacementBetween(start, peg.path(std::max(0.0, t - 1.0)) * partFromGrip,
                                        SixAxisArm::kLever);
  };
  double deepest = 0.0;
  while (sites.time() < 1.0 + peg.duration) {
    sites.step(intent);
    if (std::lround(sites.time() / kTick) % 20 != 0) continue;
    for (std::size_t i = 0; i < 2; ++i) deepest = std::max(deepest, meter.measure(sites.site(i).state).depth);
  }
  const double wanted = peg.path(peg.duration).position.z;
  for (std::size_t i = 0; i < 2; ++i) {
    const double z = sites.site(i).part().worldFromPart.position.z;
    if (atFullSize())
      std::printf("tied peg, site %zu: %.2f of %.2f mm, depth %.2f um, %.4f mJ\n", i, 1e3 * z, 1e3 * wanted,
                  1e6 * deepest, 1e3 * sites.maxCreated);
    EXPECT_NEAR(z, wanted, 2e-3) << i;
  }
  EXPECT_LE(deepest, 5e-6);
  EXPECT_LE(sites.maxCreated, kEnergyBound);
  EXPECT_EQ(sites.allocations, 0u);
}

enum class HandOver { carriesOn, beginsAnew, setsThePose };

struct Change {
  double excess = 0.0;  // N in 20 ms, beyond what there was in the second before
  double most = 0.0;    // N in 20 ms
};

/// Runs to `until`, site by site what changes after `at`.
Change changeAfter(LinkedSites& sites, std::size_t count, double at, double until,
                   const LinkedSites::Intent& intent, const std::function<void(double)>& each) {
  std::vector<double> before;
  Change change;
  while (sites.time() < until) {
    each(sites.time());
    sites.step(intent);
    double most = 0.0;
    for (std::size_t i = 0; i < count; ++i) most = std::max(most, sites.site(i).change);
    if (sites.time() > at - 1.0 && sites.time() <= at) before.push_back(most);
    if (sites.time() > at) change.most = std::max(change.most, most);
  }
  std::sort(before.begin(), before.end());
  change.excess = change.most - before[before.size() * 99 / 100];
  return change;
}

bool isAt(double now, double time) { return std::abs(now - time) < 0.5 * kTick; }

/// In tension the owner changes from site 0 to site 1, which hear of it one way apart.
Change handOver(double delay, HandOver how) {
  constexpr double kAt = 5.0;
  LinkedSites sites(setupOf(delay, benchScene(), twoHands(firmArm(), firmArm())));
  sites.linkAll();
  const auto tell = [&](std::size_t site) {
    if (how != HandOver::setsThePose) return sites.link(site, 1 - site, 2, how == HandOver::carriesOn);
    if (site == 1) return;  // the owner's replica is the one that counts
    const Pose pose = sites.site(1).part().worldFromPart;
    for (const Kind kind : {Kind::disown, Kind::own, Kind::grasp}) sites.command(0, {kind, 0, pose});
  };
  return changeAfter(sites, 2, kAt, kAt + 0.5, pullWay, [&](double now) {
    if (isAt(now, kAt)) tell(0);
    if (isAt(now, kAt + delay)) tell(1);
  });
}

TEST(LinkedSites, ChangeOfOwnerInTensionIsNotFelt) {
  for (const double delay : {0.010, 0.050, 0.100}) {
    const Change change = handOver(delay, HandOver::carriesOn);
    if (atFullSize())
      std::printf("tied, hand-over %3.0f ms: %.4f N in 20 ms beyond before\n", 1e3 * delay, change.excess);
    EXPECT_LE(change.excess, 0.04) << delay;
  }
}

/// The owner of a star of three changes from site 0 to site 1, while sites 1 and 2 pull at site 0.
Change changeOfHub(double delay) {
  constexpr double kAt = 7.0;
  LinkedSites sites(setupOf(delay, benchScene(), {{firmArm(), {}}, {firmArm(), {}}, {firmArm(), {}}}));
  sites.linkAll();
  const auto intent = [](double t, int site) {
    const double way = 0.01 * minimumJerk((t - 1.0) / 0.4);
    return site == 0 ? SixAxes{} : SixAxes{{site == 1 ? way : 0.0, site == 2 ? way : 0.0, 0.0}, {}};
  };
  const Change change = changeAfter(sites, 3, kAt, kAt + 4.0, intent, [&](double now) {
    for (std::size_t site = 0; site < 3; ++site) {
      if (!isAt(now, kAt + (site == 0 ? 0.0 : delay))) continue;
      if (site < 2) sites.link(site, 1 - site, 2, true);
      if (site > 0) sites.link(site, 3 - site, 2);
      if (site == 0) sites.site(0).state.endLink({0, 3});
      if (site == 2) sites.site(2).state.endLink({0, 1});
    }
  });
  for (std::size_t site = 0; site < 3; ++site) {
    EXPECT_EQ(sites.site(site).part().links.count, site == 1 ? 2 : 1);
    EXPECT_GT(sites.site(site).part().links.fade, 0.99);
    if (atFullSize())
      std::printf("  hub site %zu %.3f N\n", site, glm::length(sites.site(site).onHand().force));
  }
  EXPECT_LE(sites.maxCreated, kEnergyBound);
  return change;
}

TEST(LinkedSites, HubOfThreeChangesWithoutAStep) {
  for (const double delay : {0.010, 0.050}) {
    const Change change = changeOfHub(delay);
    if (atFullSize())
      std::printf("tied, hub changes %3.0f ms: %.4f N in 20 ms beyond before\n", 1e3 * delay, change.excess);
    EXPECT_LE(change.excess, 0.04 + kQuantum) << delay;
  }
}

TEST(LinkedSites, ChangeOfOwnerIsFeltIfTheLinkBeginsAnewOrThePoseIsSet) {
  for (const HandOver how : {HandOver::beginsAnew, HandOver::setsThePose}) {
    const Change change = handOver(0.050, how);
    if (atFullSize()) std::printf("  control: %.4f N\n", change.excess);
    EXPECT_GT(change.excess, 0.04);
  }
}

enum class End { runsOut, atOnce };

/// In tension the link ends at both sites, as where the owner is lost and the co-holder owns the part from
/// there on.
Change endLinkInTension(double delay, End how) {
  constexpr double kAt = 5.0;
  LinkedSites sites(setupOf(delay, benchScene(), twoHands(firmArm(), firmArm())));
  sites.linkAll();
  const Change change = changeAfter(sites, 2, kAt, kAt + 4.0, pullWay, [&](double now) {
    if (!isAt(now, kAt)) return;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto peer = static_cast<SiteId>(2 - i);
      EXPECT_GT(glm::length(sites.site(i).onHand().force), 0.5);
      if (how == End::runsOut) sites.site(i).state.endLink({0, peer});
      if (how == End::atOnce) sites.site(i).state.data().held.links().forget(0);
    }
  });
  for (std::size_t i = 0; i < 2 && how == End::runsOut; ++i) {
    EXPECT_EQ(sites.site(i).out.hands[0].held, 0);
    EXPECT_EQ(sites.site(i).part().links.count, 0);
    EXPECT_EQ(sites.site(i).body().mass, 1.0);
    EXPECT_TRUE(sites.site(i).body().inertia == benchScene().parts[0].massProperties.inertia);
    EXPECT_LT(glm::length(sites.site(i).onHand().force), 0.1);
  }
  EXPECT_LE(sites.maxCreated, kEnergyBound);
  return change;
}

TEST(LinkedSites, TieThatEndsInTensionRunsItsForceOutAndTheHandsHoldOn) {
  for (const double delay : {0.010, 0.050, 0.100}) {
    const Change change = endLinkInTension(delay, End::runsOut);
    if (atFullSize()) std::printf("linked, ended %3.0f ms: %.3f N in 20 ms\n", 1e3 * delay, change.most);
    EXPECT_LE(change.most, 0.04 + 3.0 * kQuantum) << delay;
  }
  const Change control = endLinkInTension(0.010, End::atOnce);
  if (atFullSize()) std::printf("  control: %.3f N\n", control.most);
  EXPECT_GT(control.most, 0.3);
}

TEST(LinkedSites, TieThatEndsAtFullSpeedIsNotFelt) {
  for (const double delay : {0.010, 0.050}) {
    LinkedSites sites(setupOf(delay, benchScene(), twoHands(firmArm(), lightArm())));
    sites.linkAll();
    const auto intent = [](double t, int who) { return who == 0 ? dragPath(t) : SixAxes{}; };
    const Change change = changeAfter(sites, 2, 4.0, 6.0, intent, [&](double now) {
      for (std::size_t i = 0; i < 2; ++i)
        if (isAt(now, 4.0)) sites.site(i).state.endLink({0, static_cast<SiteId>(2 - i)});
    });
    if (atFullSize())
      std::printf("linked, ended at speed %3.0f ms: %.3f N in 20 ms, %.3f beyond before\n", 1e3 * delay,
                  change.most, change.excess);
    EXPECT_LE(change.most, 0.35) << delay;  // as in link_disturbed_test
    EXPECT_LE(sites.maxCreated, kEnergyBound) << delay;
  }
}

TEST(LinkedSites, OwnersHandMayLetGoWhileTheCoHolderHoldsOn) {
  LinkedSites sites(setupOf(0.050, benchScene(), twoHands(firmArm(), firmArm())));
  sites.linkAll();
  const Change change = changeAfter(sites, 2, 5.0, 9.0, pullWay, [&](double now) {
    if (isAt(now, 5.0)) sites.command(0, {Kind::letGo, 0, {}});
  });
  const haptics::OwnedPart &left = sites.site(0).part(), &held = sites.site(1).part();
  const double gap = glm::length(left.worldFromPart.position - held.worldFromPart.position);
  if (atFullSize()) std::printf("tied, let go: %.3f N in 20 ms, %.2f mm apart\n", change.most, 1e3 * gap);
  EXPECT_FALSE(left.held);
  EXPECT_FALSE(left.atRest);
  EXPECT_EQ(left.links.count, 1);
  EXPECT_TRUE(held.held);
  EXPECT_LT(gap, 2e-3);
  EXPECT_LE(change.most, 0.3);
  EXPECT_LE(sites.maxCreated, kEnergyBound);
}

TEST(LinkedSites, OwnerThatFallsSilentLeavesTheCoHolderItsHold) {
  LinkedSites sites(setupOf(0.050, benchScene(), twoHands(firmArm(), firmArm())));
  sites.linkAll();
  const Change change = changeAfter(sites, 2, 5.0, 9.0, pullWay, [&](double now) {
    if (isAt(now, 5.0)) sites.silence(0);
    if (isAt(now, 7.0)) sites.site(1).state.endLink({0, 1});
  });
  if (atFullSize()) std::printf("tied, owner silent: %.3f N in 20 ms\n", change.most);
  EXPECT_LE(change.most, 0.3);
  EXPECT_EQ(sites.site(1).out.hands[0].held, 0);
  EXPECT_EQ(sites.site(1).part().links.count, 0);
  EXPECT_EQ(sites.site(1).body().mass, 1.0);
}

/// N rms on site 0, which drags the part to and fro.
double leadersForce(int simulators) {
  LinkedSites sites(setupOf(0.025, benchScene(), twoHands(firmArm(), lightArm())));
  sites.linkAll();
  for (std::size_t i = 0; i < 2; ++i) sites.share(i, simulators);
  double square = 0.0, ticks = 0.0;
  while (sites.time() < 6.0) {
    sites.step([](double t, int who) { return who == 0 ? dragPath(t) : SixAxes{}; });
    if (sites.time() < 3.0) continue;
    const glm::dvec3 force = sites.site(0).onHand().force;
    square += glm::dot(force, force);
    ticks += 1.0;
  }
  EXPECT_LE(sites.maxCreated, kEnergyBound);
  return std::sqrt(square / ticks);
}

TEST(LinkedSites, ReplicasWeighTogetherWhatThePartWeighs) {
  constexpr double kLoadWithoutDelay = 1.02;  // N rms, as in link_figures_test
  const double shared = leadersForce(2), whole = leadersForce(1);
  if (atFullSize()) std::printf("tied, leader: %.2f N rms, masses not shared %.2f\n", shared, whole);
  EXPECT_LE(shared, 1.2 * kLoadWithoutDelay);
  EXPECT_GT(whole, 1.2 * kLoadWithoutDelay);
}

TEST(LinkedSites, WhatALinkSaysItGaveThePartHasGot) {
  // In free air the momentum of a replica changes by what the hand and the link put on it. A step without the
  // link's damping, or with it at another place, breaks this.
  LinkedSites sites(setupOf(0.025, benchScene(), twoHands(firmArm(), lightArm())));
  sites.linkAll();
  const auto intent = [](double t, int who) { return who == 0 ? dragPath(t) : SixAxes{}; };
  sites.runTo(3.0, intent);  // masses have come to their shares
  LinkedSites::Site& site = sites.site(0);
  double mostForce = 0.0;
  int steady = 0;
  for (int i = 0; i < 500; ++i) {
    const double mass = site.body().mass;
    const auto velocity = [&] {
      const haptics::RigidBody& body = site.body();
      return velocityAt(body.worldFromBody, body.twist,
                        transformPoint(body.worldFromBody, body.centreOfMass));
    };
    const glm::dvec3 before = velocity();
    sites.step(intent);
    const Wrench& link = site.part().links.pull;
    const glm::dvec3 got = mass * (velocity() - before) / kTick;
    const glm::dvec3 said = link.force - site.onHand().force;
    if (site.body().mass != mass) continue;  // it follows that of the link
    ++steady;
    ASSERT_LT(glm::length(got - said), 1e-9) << sites.time();
    mostForce = std::max(mostForce, glm::length(link.force));
  }
  EXPECT_GT(mostForce, 0.2);
  EXPECT_GT(steady, 50);
}

TEST(LinkedSites, WhatLeadsAPartCarriesItsWeightAndIsTold) {
  // A peer that never fades in: the link carries nothing, what leads the part all of it.
  constexpr SiteId kPeer = 9;
  LinkedSites sites(setupOf(0.025, benchScene(), twoHands(firmArm(), firmArm())));
  sites.parameters.gravity = {0.0, 0.0, -9.81};
  LinkedSites::Site& site = sites.site(0);
  const Pose start = site.state.worldFromPart(1);
  sites.command(0, {Kind::own, 1, start});
  const auto still = [](double, int) { return SixAxes{}; };
  sites.step(still);
  haptics::LinkTerms terms{{1, kPeer}, {}, 0.025, 1};
  terms.outageSpring = true;
  ASSERT_TRUE(site.state.beginLink(terms));
  const haptics::RigidBody& body = site.state.data().held.parts()[1].body;
  const auto velocity = [&] {
    return velocityAt(body.worldFromBody, body.twist, transformPoint(body.worldFromBody, body.centreOfMass));
  };
  haptics::LinkPacket peer;
  peer.epoch = 1;
  peer.worldFromDrawn = start * Pose{body.centreOfMass, {1.0, 0.0, 0.0, 0.0}};
  const double begun = sites.time();
  double mostForce = 0.0;
  int steady = 0;
  while (sites.time() < begun + 3.0) {
    const double t = sites.time() - begun;
    peer.twist.linear.y = t > 0.5 && t < 1.5 ? 0.05 : 0.0;
    peer.worldFromDrawn = integrate(peer.worldFromDrawn, peer.twist, kTick);
    ++peer.sequence;
    peer.time = sites.time();
    ASSERT_TRUE(site.state.receive({{1, kPeer}, peer}));
    const double mass = body.mass;
    const glm::dvec3 before = velocity();
    sites.step(still);
    const haptics::LinkReport& told = site.out.simulated(1)->links;
    if (t < 0.1 || body.mass != mass) continue;  // it is not fully led yet; its mass follows that of the link
    ++steady;
    ASSERT_LT(glm::length(mass * (velocity() - before) / kTick - told.pull.force - told.outagePull.force),
              1e-9)
        << t;
    mostForce = std::max(mostForce, glm::length(told.outagePull.force));
  }
  EXPECT_GT(steady, 100);
  EXPECT_GT(mostForce, 0.1);
  const Pose centre = body.worldFromBody * Pose{body.centreOfMass, {1.0, 0.0, 0.0, 0.0}};
  EXPECT_LT(glm::length(centre.position - peer.worldFromDrawn.position), 1e-4) << "m";
}

TEST(LinkedSites, PullHarderThanTheirDevicesCan) {
  for (const double delay : {0.010, 0.025, 0.050, 0.100}) {
    LinkedSites sites(setupOf(delay, benchScene(), twoHands(firmArm(), firmArm())));
    sites.linkAll();
    sites.runTo(8.0, [](double t, int who) { return who == 0 ? dragPath(t) : SixAxes{}; });
    BenchSetup setup;
    setup.network.delay = delay;
    setup.sites = twoHands(firmArm(), firmArm());
    LinkBench bench(setup);
    bench.runTo(8.0, [](double t, int who) { return who == 0 ? dragPath(t) : SixAxes{}; });
    if (atFullSize())
      std::printf("tied, saturated %3.0f ms: %.4f mJ, bench %.4f\n", 1e3 * delay, 1e3 * sites.maxCreated,
                  1e3 * bench.maxCreated);
    EXPECT_LE(sites.maxCreated, kEnergyBound) << delay;
  }
}

TEST(LinkedSites, SayWhatTheLinkIsGoodFor) {
  for (const auto& [delay, regime] :
       {std::pair{0.025, haptics::LinkRegime::stiff}, std::pair{0.100, haptics::LinkRegime::soft},
        std::pair{0.250, haptics::LinkRegime::apart}}) {
    LinkedSites sites(setupOf(delay, benchScene(), twoHands(firmArm(), firmArm())));
    EXPECT_EQ(sites.site(0).part().links.count, 0);
    sites.linkAll();
    sites.runTo(2.0, [](double, int) { return SixAxes{}; });
    for (std::size_t i = 0; i < 2; ++i) {
      const haptics::LinkReport& links = sites.site(i).part().links;
      EXPECT_EQ(links.count, 1);
      EXPECT_EQ(links.regime, regime) << delay;
      EXPECT_EQ(links.fade > 0.99, regime != haptics::LinkRegime::apart) << delay;
      EXPECT_GE(links.delay, delay);
      EXPECT_FALSE(sites.site(i).part().atRest);
    }
  }
}

TEST(LinkedSites, PartsThatAreNotTiedKeepTheirBits) {
  // Both sites simulate the far block as well; at one of them that is tied, to nobody who answers.
  LinkedSites sites(setupOf(0.025, benchScene(), twoHands(firmArm(), firmArm())));
  const Pose wall = sites.site(0).state.worldFromPart(1);
  for (std::size_t i = 0; i < 2; ++i) sites.command(i, {Kind::own, 1, wall});
  const auto intent = [](double t, int) { return dragPath(t); };
  sites.runTo(0.5, intent);
  EXPECT_TRUE(sites.site(0).state.beginLink({{1, 9}, {}, 0.025, 1}));
  while (sites.time() < 3.0) {
    sites.step(intent);
    const LinkedSites::Site &tied = sites.site(0), &free = sites.site(1);
    ASSERT_TRUE(tied.part().worldFromPart.position == free.part().worldFromPart.position) << sites.time();
    ASSERT_TRUE(tied.part().worldFromPart.orientation == free.part().worldFromPart.orientation);
    ASSERT_TRUE(tied.onHand().force == free.onHand().force);
  }
  EXPECT_EQ(sites.site(0).out.owned[1].links.count, 1);
  EXPECT_EQ(sites.site(1).out.owned[1].links.count, 0);
  EXPECT_FALSE(sites.site(0).out.owned[1].atRest);
  EXPECT_TRUE(sites.site(1).out.owned[1].atRest);
}

TEST(LinkedSites, TakeNothingThatIsNotForThem) {
  LinkedSites sites(setupOf(0.025, benchScene(), twoHands(firmArm(), firmArm())));
  haptics::TickState& state = sites.site(0).state;
  haptics::LinkPacket packet;
  packet.epoch = 7;
  EXPECT_FALSE(state.beginLink({{1, 2}, {}, 0.025, 7}));  // not owned here
  EXPECT_FALSE(state.receive({{0, 2}, packet}));          // not tied
  EXPECT_TRUE(state.beginLink({{0, 2}, {}, 0.025, 7}));
  EXPECT_FALSE(state.receive({{0, 3}, packet}));  // another peer
  EXPECT_FALSE(state.receive({{1, 2}, packet}));  // another part
  packet.energy = -1.0;
  EXPECT_FALSE(state.receive({{0, 2}, packet}));
  packet.energy = 0.0;
  packet.epoch = 6;
  EXPECT_FALSE(state.receive({{0, 2}, packet}));
  packet.epoch = 7;
  EXPECT_TRUE(state.receive({{0, 2}, packet}));
  for (int peer = 3; peer < 2 + haptics::ReplicaLinks::kMaxLinks; ++peer)
    EXPECT_TRUE(state.beginLink({{0, static_cast<SiteId>(peer)}, {}, 0.025, 7}));
  EXPECT_FALSE(state.beginLink({{0, 99}, {}, 0.025, 7}));  // no room
  sites.command(0, {Kind::disown, 0, {}});
  sites.runTo(0.01, [](double, int) { return SixAxes{}; });
  EXPECT_FALSE(state.receive({{0, 2}, packet}));
}

}  // namespace
}  // namespace tandem::test
