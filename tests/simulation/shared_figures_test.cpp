// Two people hold one part: the figures of what they feel of each other at several delays, from hand to hand
// through ticks, links, wire and server. TANDEM_FULL_SIZE prints the figures.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "tests/simulation/bounds.h"
#include "tests/simulation/shared_sessions.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

const std::uint64_t kFigureSeeds = seedsUpTo(20);
constexpr std::array<double, 5> kDelays{10.0, 25.0, 50.0, 100.0, 250.0};  // ms, one way

struct Arms {
  const char* name;
  haptics::ArmParameters owner, coHolder;
};
const std::array<Arms, 3> kArms{{{"relaxed", relaxedArm(), relaxedArm()},
                                 {"mixed", firmArm(), relaxedArm()},
                                 {"firm", firmArm(), firmArm()}}};

/// The least, greatest and mean of a figure over seeds.
struct Spread {
  double least = 1e300, largest = -1e300, sum = 0.0;
  int count = 0;
  void add(double x) { least = std::min(least, x), largest = std::max(largest, x), sum += x, ++count; }
  double mean() const { return sum / count; }
};

void expectHonest(const client::SimulationResult& result) {
  EXPECT_TRUE(result.violations.empty()) << describe(result);
  EXPECT_LE(result.energyOfLinks, kEnergyBound);
  for (const auto& [name, site] : result.sites) EXPECT_LE(site.energyCreated, kEnergyBound) << name;
}

/// The stiffness between two hands while the second one pulls, N/m.
double handToHand(SharedSession& session) {
  double force = 0.0, displacement = 0.0, start = 0.0;
  session.options.watch = [&](double t, std::span<const client::SimulatedSiteState> sites) {
    const double apart = sites[1].device.x - sites[0].device.x;
    if (t < 4.9) start = apart;
    if (t < 8.0) return;
    displacement += apart - start;
    force += 0.5 * (sites[0].force.x - sites[1].force.x);
  };
  expectHonest(session.run());
  return force / displacement;
}

TEST(SharedFigures, HandsFeelEachOtherAsStiffAsTheDelayAllows) {
  constexpr std::array<double, 5> kBound{270.0, 217.0, 164.0, 66.0,
                                         0.0};  // N/m; there is no link beyond 150 ms
  for (const Arms& arms : kArms) {
    SharedSession session("shared_pull");
    session.arm(0) = arms.owner;
    session.arm(1) = arms.coHolder;
    for (std::size_t i = 0; i < kDelays.size(); ++i) {
      Spread stiffness;
      session.setDelay(kDelays[i]);
      for (session.options.seed = 1; session.options.seed <= kFigureSeeds; ++session.options.seed)
        stiffness.add(handToHand(session));
      if (atFullSize())
        std::printf("hand to hand, %-7s %3.0f ms: %3.0f N/m (%3.0f..%3.0f)\n", arms.name, kDelays[i],
                    stiffness.mean(), stiffness.least, stiffness.largest);
      if (kBound[i] > 0.0) {
        EXPECT_GE(stiffness.least, kBound[i]) << arms.name << " " << kDelays[i];
      }
      if (kDelays[i] > 200.0) {
        EXPECT_LT(stiffness.largest, 5.0) << "there should be no link";
      }
    }
  }
}

TEST(SharedFigures, SharedDragKeepsReplicasTogetherAndTheLeaderUnburdened) {
  constexpr std::array<double, 5> kFelt{1.2e-3, 2e-3, 3.7e-3, 10e-3, 1.0};         // m rms
  constexpr std::array<double, 5> kDisplayed{0.5e-3, 0.5e-3, 0.5e-3, 1e-3, 6e-3};  // m rms
  constexpr std::array<double, 5> kLeader{1.1, 1.2, 1.4, 1.5, 1.0};
  for (const auto& coHolder : {relaxedArm(), lightArm()}) {
    SharedSession session("shared_drag");
    session.arm(1) = coHolder;
    const auto leaderForce = [&](Spread& felt, Spread& displayed) {
      double squares = 0.0;
      int count = 0;
      session.options.watch = [&](double t, std::span<const client::SimulatedSiteState> sites) {
        if (t < 6.0 || t > 12.5) return;
        squares += glm::dot(sites[0].force, sites[0].force);
        ++count;
      };
      const client::SimulationResult result = session.run();
      expectHonest(result);
      felt.add(result.discrepancyRms);
      displayed.add(result.displayedRms);
      return std::sqrt(squares / count);
    };
    Spread ignored;
    session.setDelay(1.0);
    const double near = leaderForce(ignored, ignored);
    for (std::size_t i = 0; i < kDelays.size(); ++i) {
      Spread felt, displayed, ratio;
      session.setDelay(kDelays[i]);
      for (session.options.seed = 1; session.options.seed <= kFigureSeeds; ++session.options.seed)
        ratio.add(leaderForce(felt, displayed) / near);
      if (atFullSize())
        std::printf("drag, arm of %3.0f N/m %3.0f ms: felt %.2f mm, displayed %.3f mm, leader %.2f\n",
                    coHolder.stiffness, kDelays[i], 1e3 * felt.largest, 1e3 * displayed.largest,
                    ratio.largest);
      EXPECT_LE(felt.largest, kFelt[i]) << kDelays[i];
      EXPECT_LE(displayed.largest, kDisplayed[i]) << kDelays[i];
      EXPECT_LE(ratio.largest, kLeader[i]) << kDelays[i];
    }
  }
}

/// A session that is cut off at `end` s.
client::SimulationResult cutOff(SharedSession& session, double end) {
  session.scenario.duration = end;
  return session.run();
}

/// The bytes that a site sends in a session of `end` s: all messages, and 32 for the seal of each datagram.
double sentBy(const client::SimulationResult& result, const std::string& site, double end) {
  const client::SimulatedSiteResult& sent = result.sites.at(site);
  return end * (sent.bytesPerSecond + 32.0 * sent.packetsPerSecond);
}

// Links, states, presence, pings and acknowledgements together, while two people drag a part to and fro.
TEST(SharedFigures, ASharedPartTakesFewBytesASecond) {
  struct Rate {
    double hz, largest;  // kB/s
  };
  for (const Rate& rate : {Rate{250.0, 24.0}, Rate{100.0, 10.0}}) {
    SharedSession session("shared_drag");
    session.setDelay(25.0);
    session.scenario.packetHz = rate.hz;
    const client::SimulationResult whole = cutOff(session, 13.0), beginning = cutOff(session, 5.0);
    for (const char* site : {"a", "b"}) {
      const double each = 1e-3 * (sentBy(whole, site, 13.0) - sentBy(beginning, site, 5.0)) / 8.0;
      if (atFullSize()) std::printf("sent by %s at %.0f packets a second: %.2f kB/s\n", site, rate.hz, each);
      EXPECT_LE(each, rate.largest) << site << " " << rate.hz;
      EXPECT_GE(each, 0.032 * rate.hz) << "less than the seals of its packets";
    }
  }
}

TEST(SharedFigures, CoHolderFeelsTheWallAsIfAlone) {
  for (const double delay : kDelays) {
    SharedSession session("shared_wall");
    session.setDelay(delay);
    Spread felt;
    for (session.options.seed = 1; session.options.seed <= kFigureSeeds; ++session.options.seed) {
      const client::SimulationResult result = session.run();
      expectHonest(result);
      felt.add(result.sites.at("b").feltStiffness);
    }
    if (atFullSize())
      std::printf("wall, co-holder %3.0f ms: %3.0f N/m (%3.0f..%3.0f)\n", delay, felt.mean(), felt.least,
                  felt.largest);
    EXPECT_GE(felt.least, 830.0) << delay;
  }
}

struct Pressing {
  double stiffness = 0.0;  // N/m
  double ripple = 0.0;     // N, largest deviation of either hand's force from its mean once both have settled
};

/// Two sites press their parts together: the force at the hands over the distance by which they are nearer
/// than at the first touch.
Pressing pressedTogether(SharedSession& session) {
  constexpr double kGap = 0.03;  // m, between the parts at first
  double start = 0.0, force = 0.0, displacement = 0.0;
  std::array<Spread, 2> forces;
  session.options.watch = [&](double t, std::span<const client::SimulatedSiteState> sites) {
    const double apart = sites[0].device.y - sites[1].device.y;
    if (t < 2.9) start = apart;
    if (t < 6.5 || t > 7.9) return;
    displacement += start - apart - kGap;
    force += 0.5 * (sites[0].force.y - sites[1].force.y);
    for (std::size_t i = 0; i < 2; ++i) forces[i].add(sites[i].force.y);
  };
  const client::SimulationResult result = session.run();
  expectHonest(result);
  EXPECT_GT(result.shared, 3.0) << "nobody simulated the other one's part";
  Pressing pressing;
  pressing.stiffness = force / displacement;
  for (const Spread& hand : forces)
    pressing.ripple = std::max({pressing.ripple, hand.largest - hand.mean(), hand.mean() - hand.least});
  return pressing;
}

TEST(SharedFigures, PartsOfTwoOwnersArePressedTogether) {
  constexpr std::array<double, 5> kBound{330.0, 280.0, 235.0, 100.0, 44.0};  // N/m; 458 without a network
  constexpr double kRipple = 0.15;  // N: about the just noticeable difference
  for (std::size_t i = 0; i < kDelays.size(); ++i) {
    SharedSession session("pressed_together");
    session.setDelay(kDelays[i]);
    Spread stiffness, ripple;
    for (session.options.seed = 1; session.options.seed <= kFigureSeeds; ++session.options.seed) {
      const Pressing pressing = pressedTogether(session);
      stiffness.add(pressing.stiffness);
      ripple.add(pressing.ripple);
    }
    if (atFullSize())
      std::printf("pressed together %3.0f ms: %3.0f N/m (%3.0f..%3.0f), ripple at most %.3f N\n", kDelays[i],
                  stiffness.mean(), stiffness.least, stiffness.largest, ripple.largest);
    EXPECT_GE(stiffness.least, kBound[i]) << kDelays[i];
    EXPECT_LE(ripple.largest, kRipple) << kDelays[i];
  }
}

}  // namespace
}  // namespace tandem::test
