// Shared parts while hands let go, links break, delays change and programs die: the scenarios of this folder,
// each with several seeds. TANDEM_FULL_SIZE prints the figures.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <glm/geometric.hpp>
#include <vector>

#include "tests/simulation/bounds.h"
#include "tests/simulation/shared_sessions.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

const std::uint64_t kSeeds = seedsUpTo(6);
constexpr double kOutageStep = 0.3;  // N in 20 ms, of which the drag itself causes up to 0.25
constexpr double kQuantum = 0.06;    // N: the device's quantum through the grasp's spring
constexpr std::size_t kA = 0, kB = 1;
constexpr PartId kBlock = 0;

/// Records one session, site by site.
class Watch {
 public:
  explicit Watch(SharedSession& session) {
    session.options.watch = [this](double t, std::span<const client::SimulatedSiteState> sites) {
      sites_.resize(sites.size());
      for (std::size_t i = 0; i < sites.size(); ++i) sites_[i].add(t, sites[i]);
    };
  }

  /// N: the largest change of a hand's force in 20 ms that ends within these times (s).
  double step(std::size_t site, double from, double to) const {
    const std::vector<glm::dvec3>& force = sites_[site].force;
    double largest = 0.0;
    for (std::size_t i = at(from); i < std::min(at(to), force.size()); ++i)
      largest = std::max(largest, changeIn20ms(force, i));
    return largest;
  }
  double force(std::size_t site, double t) const { return glm::length(sites_[site].force[at(t)]); }
  const haptics::LinkReport& links(std::size_t site, double t) const { return sites_[site].links[at(t)]; }
  bool holds(std::size_t site, double t) const { return sites_[site].held[at(t)] == kBlock; }
  /// m between the replicas of two sites.
  double apart(std::size_t a, std::size_t b, double t) const {
    return glm::length(sites_[a].block[at(t)] - sites_[b].block[at(t)]);
  }

 private:
  struct Site {
    std::vector<glm::dvec3> force, block;
    std::vector<haptics::LinkReport> links;
    std::vector<PartId> held;
    void add(double, const client::SimulatedSiteState& state) {
      const haptics::OwnedPart* part = state.tick->simulated(kBlock);
      force.push_back(state.force);
      block.push_back(part != nullptr ? part->worldFromPart.position : glm::dvec3(NAN));
      links.push_back(part != nullptr ? part->links : haptics::LinkReport{});
      held.push_back(state.tick->hands[0].held);
    }
  };
  static std::size_t at(double t) { return static_cast<std::size_t>(std::lround(t * 1e3)); }

  std::vector<Site> sites_;
};

/// Runs a scenario with several seeds. No session may break a rule or create energy.
template <typename Change, typename Check>
void forSeeds(const char* scenario, double delay, std::uint64_t seeds, const Change& change,
              const Check& check) {
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SharedSession session(scenario);
    session.setDelay(delay);
    session.options.seed = seed;
    change(session.scenario);
    Watch watch(session);
    const client::SimulationResult result = session.run();
    SCOPED_TRACE(std::string(scenario) + ", " + std::to_string(delay) + " ms, seed " + std::to_string(seed));
    EXPECT_TRUE(result.violations.empty()) << describe(result);
    EXPECT_LE(result.energyOfLinks, kEnergyBound);
    for (const auto& [name, site] : result.sites) EXPECT_LE(site.energyCreated, kEnergyBound) << name;
    check(result, watch);
  }
}
template <typename Check>
void forSeeds(const char* scenario, double delay, const Check& check) {
  forSeeds(
      scenario, delay, kSeeds, [](client::Scenario&) {}, check);
}

void print(const char* what, double delay, const char* unit, double value) {
  if (atFullSize()) std::printf("%-40s %3.0f ms: %.4f %s\n", what, delay, value, unit);
}

TEST(SharedHardCases, BothLetGoInTension) {
  for (const double delay : {10.0, 25.0, 50.0, 100.0}) {
    double largest = 0.0;
    forSeeds("shared_let_go", delay, [&](const client::SimulationResult& result, const Watch& watch) {
      EXPECT_GT(watch.force(kA, 7.9), 0.5) << "there was no tension";
      EXPECT_TRUE(result.stable);
      for (const std::size_t site : {kA, kB}) {
        EXPECT_FALSE(watch.holds(site, 10.0));
        largest = std::max(largest, watch.step(site, 8.0, 9.0));
      }
    });
    print("both let go", delay, "N in 20 ms", largest);
    EXPECT_LE(largest, 0.3 + kQuantum) << delay;
  }
}

/// One of two co-holders lets go at `at` (s). Returns the largest change of force that the other one feels
/// within the second after it, N in 20 ms. If the owner lets go, the other one becomes the owner; else the
/// roles stay.
double letGo(const char* scenario, double at, double delay, bool ownerDoes) {
  constexpr std::uint64_t kCompared = 6;  // seeds, over which the largest values are compared
  double largest = 0.0;
  for (std::uint64_t seed = 1; seed <= kCompared; ++seed) {
    SharedSession session(scenario);
    session.setDelay(delay);
    session.options.seed = seed;
    // The steps of a coarser reading would hide the change that is measured.
    for (client::ScenarioSite& site : session.scenario.sites) site.device.quantum = 1e-6;
    if (!ownerDoes) session.delayGrasp(kA, 2.8);  // b has the part first
    Watch watch(session);
    const client::SimulationResult result = session.run();
    SCOPED_TRACE(std::string(scenario) + ", " + std::to_string(delay) + " ms, seed " + std::to_string(seed));
    EXPECT_TRUE(result.violations.empty()) << describe(result);
    EXPECT_LE(result.energyOfLinks, kEnergyBound);
    EXPECT_EQ(result.grants.size(), ownerDoes ? 2u : 1u) << describe(result);
    EXPECT_EQ(result.siteNames.at(result.grants.back().site), "b");
    EXPECT_EQ(watch.links(kB, at - 0.1).count, 1);
    EXPECT_TRUE(watch.holds(kB, at + 2.0));
    EXPECT_EQ(watch.links(kB, at + 2.0).count, 0);
    EXPECT_EQ(watch.links(kB, at + 2.0).share, 1.0);
    largest = std::max(largest, watch.step(kB, at, at + 1.0));
  }
  return largest;
}

TEST(SharedHardCases, WhoIsLeftWithAPartFeelsNothingOfBecomingItsOwner) {
  struct Case {
    const char* scenario;
    double at;  // s
  };
  for (const Case& c : {Case{"shared_one_lets_go", 8.0}, Case{"shared_speed_hand_over", 8.0},
                        Case{"shared_pressed_hand_over", 8.5}}) {
    for (const double delay : {10.0, 25.0, 50.0, 100.0}) {
      const double withChange = letGo(c.scenario, c.at, delay, true);
      const double without = letGo(c.scenario, c.at, delay, false);
      if (atFullSize())
        std::printf("%-30s %3.0f ms: %.3f N in 20 ms, where no owner changes %.3f\n", c.scenario, delay,
                    withChange, without);
      EXPECT_LE(withChange, without + 0.04) << c.scenario << " " << delay;
      EXPECT_LE(withChange, 0.15) << c.scenario << " " << delay;
    }
  }
}

// Thirteen times each site lets go of the part and grabs it again before the reply to the release can have
// arrived.
TEST(SharedHardCases, WhoLetsGoAndGrabsAgainHoldsThePart) {
  for (const double delay : {10.0, 50.0, 100.0, 150.0}) {
    forSeeds("shared_grabs_again", delay, [&](const client::SimulationResult& result, const Watch& watch) {
      EXPECT_TRUE(result.stable);
      for (const std::size_t site : {kA, kB}) {
        EXPECT_TRUE(watch.holds(site, 16.5)) << site;
        EXPECT_FALSE(watch.holds(site, 17.9)) << site;
        EXPECT_TRUE(watch.holds(site, 22.9)) << site;
      }
    });
  }
}

// The hand still holds the part, which the other site has come to own meanwhile: it becomes a co-holder
// again.
TEST(SharedHardCases, OwnerThatStoodStillHoldsThePartAgain) {
  for (const double pause : {0.05, 0.5, 1.8}) {
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      SharedSession session("shared_pull");
      session.setDelay(25.0);
      session.scenario.faults.push_back({client::Fault::Kind::pauseSite, 8.0, pause, "a"});
      session.scenario.duration = 14.0;
      session.options.seed = seed;
      Watch watch(session);
      const client::SimulationResult result = session.run();
      SCOPED_TRACE("pause of " + std::to_string(pause) + " s, seed " + std::to_string(seed));
      EXPECT_TRUE(result.violations.empty()) << describe(result);
      for (const std::size_t site : {kA, kB}) EXPECT_TRUE(watch.holds(site, 13.9)) << site;
    }
  }
}

TEST(SharedHardCases, BlackoutsAtFullSpeedAreNotFelt) {
  for (const double delay : {10.0, 25.0, 50.0, 100.0}) {
    double largest = 0.0;
    forSeeds("shared_blackouts", delay, [&](const client::SimulationResult& result, const Watch& watch) {
      EXPECT_TRUE(result.stable);
      for (const std::size_t site : {kA, kB}) {
        largest = std::max({largest, watch.step(site, 8.0, 11.0), watch.step(site, 12.0, 16.0)});
        EXPECT_GT(watch.links(site, 15.0).fade, 0.99) << "the link did not come back";
      }
    });
    print("blackouts of 0.2 and 1 s", delay, "N in 20 ms", largest);
    EXPECT_LE(largest, kOutageStep) << delay;
  }
}

TEST(SharedHardCases, AServerThatHangsIsNoticedAndNoHandFeelsIt) {
  constexpr double kSwayEnds = 16.9;  // s, in the scenario
  for (const double hangs : {1.0, 4.0}) {
    double largest = 0.0;
    const auto hang = [&](client::Scenario& scenario) {
      scenario.blackouts.clear();
      scenario.faults.push_back({client::Fault::Kind::pauseServer, 8.0, hangs, ""});
    };
    const auto check = [&](const client::SimulationResult& result, const Watch& watch) {
      EXPECT_TRUE(result.stable);
      for (const auto& [name, site] : result.sites)
        EXPECT_EQ(site.reconnects > 0, hangs > 2.0) << name << " lost " << site.reconnects << " connections";
      for (const std::size_t site : {kA, kB}) {
        largest = std::max(largest, watch.step(site, 8.0, kSwayEnds));
        EXPECT_TRUE(watch.holds(site, kSwayEnds));
        EXPECT_GT(watch.links(site, kSwayEnds).fade, 0.99) << "the link did not come back";
      }
    };
    forSeeds("shared_blackouts", 25.0, kSeeds, hang, check);
    print("the server hangs", 1e3 * hangs, "N in 20 ms", largest);
    EXPECT_LE(largest, kOutageStep) << hangs;
  }
}

TEST(SharedHardCases, StepsOfDelayFadeTheLinkAndBringItBack) {
  double largest = 0.0;
  forSeeds("shared_delay_steps", 25.0, [&](const client::SimulationResult& result, const Watch& watch) {
    EXPECT_TRUE(result.stable);
    for (const std::size_t site : {kA, kB}) {
      largest = std::max(largest, watch.step(site, 7.0, 15.0));
      EXPECT_EQ(watch.links(site, 10.5).regime, haptics::LinkRegime::apart);
      EXPECT_EQ(watch.links(site, 10.5).share, 1.0) << "each has the whole part while they are apart";
      EXPECT_EQ(watch.links(site, 15.0).regime, haptics::LinkRegime::stiff);
      EXPECT_EQ(watch.links(site, 15.0).share, 0.5);
    }
  });
  print("25 to 250 to 25 ms", 25.0, "N in 20 ms", largest);
  EXPECT_LE(largest, 0.3);
}

TEST(SharedHardCases, CoHolderGoesOnWhereTheOwnerDies) {
  double largest = 0.0;
  forSeeds("shared_owner_killed", 25.0, [&](const client::SimulationResult& result, const Watch& watch) {
    ASSERT_EQ(result.grants.size(), 2u) << describe(result);
    EXPECT_EQ(result.siteNames.at(result.grants[1].site), "b");
    EXPECT_LE(result.grants[1].at, 8.0 + 2.2) << "within the lease";
    largest = std::max(largest, watch.step(kB, 8.0, 13.0));
    EXPECT_TRUE(watch.holds(kB, 13.0));
    EXPECT_EQ(watch.links(kB, 13.0).share, 1.0);
  });
  print("owner killed in tension", 25.0, "N in 20 ms", largest);
  EXPECT_LE(largest, 0.3);
}

TEST(SharedHardCases, OwnerThatWasPausedComesBackAsACoHolder) {
  double largest = 0.0, gap = 0.0;
  forSeeds("shared_owner_paused", 25.0, [&](const client::SimulationResult& result, const Watch& watch) {
    ASSERT_EQ(result.grants.size(), 2u) << describe(result);
    EXPECT_EQ(result.siteNames.at(result.grants[1].site), "b");
    EXPECT_TRUE(watch.holds(kB, 19.0));
    EXPECT_TRUE(watch.holds(kA, 19.0)) << "its hand never let go";
    EXPECT_EQ(watch.links(kA, 19.0).count, 1);
    EXPECT_GT(watch.links(kA, 19.0).fade, 0.99);
    EXPECT_EQ(watch.links(kA, 19.0).share, 0.5);
    largest = std::max({largest, watch.step(kB, 8.0, 19.9), watch.step(kA, 13.5, 19.9)});
    gap = std::max(gap, watch.apart(kA, kB, 19.0));
  });
  print("owner paused for 5 s", 25.0, "N in 20 ms", largest);
  print("owner paused for 5 s", 25.0, "m apart 6 s later", gap);
  EXPECT_LE(largest, 0.3);
}

TEST(SharedHardCases, NoHandFeelsTheServerDieWhileAPartIsShared) {
  double largest = 0.0;
  forSeeds("shared_server_restarts", 25.0, [&](const client::SimulationResult& result, const Watch& watch) {
    EXPECT_TRUE(result.stable);
    EXPECT_EQ(result.grants.size(), 1u) << describe(result);
    for (const std::size_t site : {kA, kB}) {
      largest = std::max(largest, watch.step(site, 8.0, 15.9));
      EXPECT_TRUE(watch.holds(site, 15.0));
      EXPECT_GT(watch.links(site, 15.0).fade, 0.99) << "the link did not come back";
      EXPECT_EQ(watch.links(site, 15.0).share, 0.5);
    }
  });
  print("server restarts", 25.0, "N in 20 ms", largest);
  EXPECT_LE(largest, 0.3);
}

/// Parts of two owners press on each other while one site sends nothing, or while there is no server.
TEST(SharedHardCases, NoHandFeelsAnOutageWhileTheirPartsPressOnEachOther) {
  struct Pressing {
    const char* scenario;
    double from, to;  // s: the hands press and stand still; in the bore, one pushes on until 6 s
  };
  struct Outage {
    const char* site;  // "": the server dies and is restarted
    double lasts;      // s
  };
  for (const Pressing& press : {Pressing{"pressed_together", 5.5, 8.0}, Pressing{"shared_bore", 4.6, 9.0}}) {
    for (const double delay : {25.0, 100.0, 250.0}) {
      double largest = 0.0;
      for (const Outage& outage : {Outage{"a", 0.3}, Outage{"b", 1.0}, Outage{"", 0.1}}) {
        const auto cut = [&](client::Scenario& scenario) {
          if (*outage.site != '\0')
            scenario.blackouts.push_back({outage.site, press.from, outage.lasts});
          else
            scenario.faults.push_back({client::Fault::Kind::killServer, press.from, outage.lasts, ""});
        };
        forSeeds(press.scenario, delay, seedsUpTo(2), cut,
                 [&](const client::SimulationResult&, const Watch& watch) {
                   for (const std::size_t site : {kA, kB}) {
                     EXPECT_GT(watch.force(site, press.from - 0.1), 0.2) << "nothing was pressed";
                     EXPECT_GT(watch.force(site, press.to - 0.1), 0.2) << "it did not hold";
                     // With a delay of 250 ms it takes up to 3 s.
                     EXPECT_GT(watch.links(site, press.to - 0.1).fade, delay < 200.0 ? 0.99 : 0.0)
                         << "the link did not come back";
                     largest = std::max(largest, watch.step(site, press.from, press.to));
                   }
                 });
      }
      print(press.scenario, delay, "N in 20 ms, in outages", largest);
      EXPECT_LE(largest, kOutageStep) << press.scenario << " " << delay;
    }
  }
}

/// One site holds a pin over a bore 4 mm wider; the part in the other hand pushes it down into the bore.
TEST(SharedHardCases, OnePushesAnothersPartIntoABore) {
  constexpr PartId kPin = 1;
  constexpr double kHalfPin = 0.04, kRoom = 0.002, kAllowed = 20e-6;  // m
  constexpr std::array<double, 4> kDelays{10.0, 25.0, 50.0, 100.0}, kApart{1e-3, 1.5e-3, 2e-3, 6e-3};
  for (std::size_t i = 0; i < kDelays.size(); ++i) {
    double shallowest = 1.0, beside = 0.0, apart = 0.0, ripple = 0.0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      SharedSession session("shared_bore");
      session.setDelay(kDelays[i]);
      session.options.seed = seed;
      std::array<double, 2> least{1e300, 1e300}, largest{-1e300, -1e300};
      session.options.watch = [&](double t, std::span<const client::SimulatedSiteState> sites) {
        if (t < 7.5 || t > 8.9) return;
        std::array<glm::dvec3, 2> pin{};
        for (const std::size_t site : {kA, kB}) {
          const haptics::OwnedPart* part = sites[site].tick->simulated(kPin);
          ASSERT_NE(part, nullptr);
          pin[site] = part->worldFromPart.position;
          shallowest = std::min(shallowest, kHalfPin - pin[site].y);
          beside = std::max({beside, std::abs(pin[site].x), std::abs(pin[site].z)});
          least[site] = std::min(least[site], sites[site].force.y);
          largest[site] = std::max(largest[site], sites[site].force.y);
        }
        apart = std::max(apart, glm::length(pin[kA] - pin[kB]));
      };
      const client::SimulationResult result = session.run();
      EXPECT_TRUE(result.violations.empty()) << describe(result);
      EXPECT_TRUE(result.stable) << kDelays[i] << " ms, seed " << seed;
      EXPECT_LE(result.energyOfLinks, kEnergyBound);
      for (const auto& [name, site] : result.sites) EXPECT_LE(site.energyCreated, kEnergyBound) << name;
      EXPECT_GT(least[kA], 0.8) << "it was not pushed";
      for (const std::size_t site : {kA, kB}) ripple = std::max(ripple, largest[site] - least[site]);
    }
    print("into a bore: how deep", kDelays[i], "mm", 1e3 * shallowest);
    print("into a bore: replicas apart", kDelays[i], "mm", 1e3 * apart);
    print("into a bore: ripple, peak to peak", kDelays[i], "N", ripple);
    EXPECT_GE(shallowest, 0.018) << kDelays[i];
    EXPECT_LE(beside, kRoom + kAllowed) << kDelays[i];
    EXPECT_LE(apart, kApart[i]) << kDelays[i];
    EXPECT_LE(ripple, 0.3) << kDelays[i];
  }
}

TEST(SharedHardCases, ManySitesOnOnePart) {
  struct Star {
    const char* scenario;
    std::size_t sites;
    double at;  // s, when all hold on
  };
  for (const Star& star : {Star{"shared_three", 3, 11.0}, Star{"shared_eight", 8, 15.0}}) {
    for (const double delay : {10.0, 25.0, 50.0}) {
      double largest = 0.0;
      forSeeds(star.scenario, delay, [&](const client::SimulationResult& result, const Watch& watch) {
        EXPECT_TRUE(result.stable);
        EXPECT_EQ(watch.links(0, star.at).count, static_cast<int>(star.sites) - 1);
        double shares = 0.0;
        for (std::size_t i = 0; i < star.sites; ++i) {
          EXPECT_GT(watch.links(i, star.at).fade, 0.99) << i;
          shares += watch.links(i, star.at).share;
          largest = std::max(largest, watch.force(i, star.at));
        }
        EXPECT_NEAR(shares, 1.0, 1e-12) << "the masses do not sum to the part's";
      });
      print(star.scenario, delay, "N, the largest force", largest);
      EXPECT_LT(largest, 3.3) << "the hub's device is at its limit";
    }
  }
}

/// Harsher networks than the scenarios have.
TEST(SharedHardCases, HalfTheDelayAsJitterAThirdLostDoublesAndDisorder) {
  for (const double delay : {10.0, 50.0, 100.0}) {
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      SharedSession session("shared_drag");
      session.setDelay(delay);
      session.options.seed = seed;
      session.scenario.network.jitter = 0.5;
      session.scenario.network.loss = 0.3;
      session.scenario.network.duplicate = 0.1;
      session.scenario.network.reorder = 0.1;
      const client::SimulationResult result = session.run();
      SCOPED_TRACE(std::to_string(delay) + " ms, seed " + std::to_string(seed));
      EXPECT_TRUE(result.stable);
      EXPECT_TRUE(result.violations.empty()) << describe(result);
      EXPECT_LE(result.energyOfLinks, kEnergyBound);
      for (const auto& [name, site] : result.sites) EXPECT_LE(site.energyCreated, kEnergyBound) << name;
    }
  }
}

}  // namespace
}  // namespace tandem::test
