// Three and eight sites that hold one part: a star of links from the first. The links share
// one impedance, so that the mass they add to the leading hand is that of a single link.

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/base/minimum_jerk.h"
#include "tests/haptics/link/link_checks.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

using haptics::minimumJerk;
using haptics::SixAxes;

struct StarFigures : Tally {
  double load = 0.0;       // N rms on the leader of a drag
  double stiffness = 0.0;  // N/m from hand to hand
};

BenchSetup starOf(int sites, double delay) {
  BenchSetup setup;
  setup.network.delay = delay;
  setup.sites.assign(static_cast<std::size_t>(sites), {lightArm(), {}});
  return setup;
}

/// `leader` drags; the others hold on, or have let go of their styluses, which hang at the part.
StarFigures dragStar(BenchSetup setup, std::size_t leader, bool othersHold) {
  setup.sites[leader].arm = firmArm();
  LinkBench bench(setup);
  for (std::size_t i = 0; i < setup.sites.size() && !othersHold; ++i)
    if (i != leader) bench.site(i).arm.letGo();
  const auto intent = [&](double t, int who) {
    return who == static_cast<int>(leader) ? dragPath(t) : SixAxes{};
  };
  StarFigures figures;
  double ticks = 0.0;
  while (bench.time() < 8.0 && !bench.astray()) {
    bench.step(intent);
    if (bench.time() < 3.0) continue;
    const glm::dvec3 force = bench.site(leader).onHand.force;
    figures.load += glm::dot(force, force);
    ticks += 1.0;
  }
  figures.note(bench);
  figures.load = std::sqrt(figures.load / ticks);
  return figures;
}

/// Site 1 pulls 15 mm away from `other`; nobody else holds.
StarFigures pullStar(BenchSetup setup, std::size_t other) {
  setup.sites[1].arm = setup.sites[other].arm = firmArm();
  LinkBench bench(setup);
  for (std::size_t i = 0; i < setup.sites.size(); ++i)
    if (i != 1 && i != other) bench.site(i).arm.letGo();
  const auto intent = [](double t, int who) {
    return who == 1 ? SixAxes{{0.015 * minimumJerk((t - 1.0) / 0.5), 0.0, 0.0}, {}} : SixAxes{};
  };
  StarFigures figures;
  double force = 0.0, way = 0.0;
  while (bench.time() < 8.0 && !bench.astray()) {
    bench.step(intent);
    if (bench.time() < 6.0) continue;
    force += glm::length(bench.site(other).onHand.force);
    way += glm::length(bench.site(1).arm.device().position - bench.site(other).arm.device().position);
    for (std::size_t i = 0; i < setup.sites.size(); ++i)
      figures.change = std::max(figures.change, bench.site(i).change);
  }
  figures.note(bench);
  figures.stiffness = force / std::max(1e-6, way);
  return figures;
}

constexpr double kLoad = 1.3;  // times that without a delay

TEST(LinkStar, ThreeAndEightSitesArePassiveAndTheLeaderCarriesOneLine) {
  struct Row {
    double delay;              // s
    double hub[2], spokes[2];  // N/m at least, three and eight sites
  };
  const Row rows[] = {{0.025, {230.0, 110.0}, {150.0, 55.0}},
                      {0.050, {120.0, 40.0}, {65.0, 16.0}},
                      {0.100, {40.0, 10.0}, {20.0, 2.0}}};
  for (const int sites : {3, 8}) {
    const std::size_t column = sites == 3 ? 0 : 1;
    // Seven arms that hold on saturate the leader's device at any delay.
    const bool hold = sites == 3;
    const double atHome = dragStar(starOf(sites, 1e-3), 0, hold).load;
    for (const Row& row : rows) {
      const BenchSetup setup = starOf(sites, row.delay);
      const StarFigures hub = dragStar(setup, 0, hold), spoke = dragStar(setup, 1, hold),
                        near = pullStar(setup, 0), far = pullStar(setup, 2);
      for (const StarFigures& f : {hub, spoke, near, far}) expectPassive(f, "star");
      if (atFullSize())
        std::printf(
            "%d sites %3.0f ms: leader's force %.2f x as hub, %.2f x as spoke, %3.0f N/m to "
            "the hub, %3.0f between spokes, %.2f N in 20 ms at rest\n",
            sites, 1e3 * row.delay, hub.load / atHome, spoke.load / atHome, near.stiffness, far.stiffness,
            std::max(near.change, far.change));
      EXPECT_LE(hub.load, kLoad * atHome) << sites << " " << row.delay;
      EXPECT_LE(spoke.load, kLoad * atHome) << sites << " " << row.delay;
      EXPECT_GE(near.stiffness, row.hub[column]) << sites << " " << row.delay;
      EXPECT_GE(far.stiffness, row.spokes[column]) << sites << " " << row.delay;
      EXPECT_LT(std::max(near.change, far.change), 0.3) << sites << " " << row.delay;
    }
  }
}

}  // namespace
}  // namespace tandem::test
