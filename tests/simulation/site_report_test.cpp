// The reports of honest sites, through the connection, a network and the session: the server has the figures
// of the site, and refuses none of them.

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "client/session/server_connection.h"
#include "tests/server/session_rig.h"

namespace tandem::client {
namespace {

using namespace sync;

/// A site of which only the connection and the totals of a loop exist, in a real session.
struct Reporting : server::SessionRig {
  LoopTotals totals;
  haptics::DurationHistogram histogram;
  Exchange exchange;
  std::unique_ptr<ServerConnection> site;

  void compute(std::int64_t time_us) {
    histogram.record(1000 * time_us);
    totals.compute = histogram.counts();
  }
  void restart() {
    crash();
    start();
  }
  void enter() {
    ConnectionOptions options;
    options.token = token(Role::participant);
    site = std::make_unique<ServerConnection>(
        options, [this]() -> Result<std::unique_ptr<Transport>> { return network.connect("site"); });
    site->setLoopTotals([this] { return totals; });
    runUntil(ServerConnection::Stage::needScene);
    site->skipTransfer();
    site->sceneReady(scene, exchange);
    runUntil(ServerConnection::Stage::ready);
  }
  void runUntil(ServerConnection::Stage stage) {
    for (int i = 0; i < 5000 && site->stage() != stage; ++i) run(kMillisecond);
    ASSERT_EQ(site->stage(), stage) << site->reason();
  }
  void afterStep() override {
    if (site) site->step(now);
  }
  server::SiteFigures atServer() const {
    const auto figures = session->figures();
    return figures.sites.empty() ? server::SiteFigures{} : figures.sites[0].figures;
  }
};

TEST(SiteReports, OfAnHonestSiteReachTheServerWholeWhateverItsLoopGoesThrough) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    std::mt19937 random(seed);
    Reporting rig;
    rig.totals.ticks = random() % 1000000;  // before it entered
    const LoopTotals before = rig.totals;
    rig.enter();
    for (int second = 0; second < 31; ++second) {
      const std::uint64_t missed = random() % 4 == 0 ? random() % 900 : random() % 3;
      rig.totals.ticks += 1000 - missed;
      rig.totals.missed += missed;
      rig.totals.forceLimited += random() % 100;
      for (int i = 0; i < 1000; ++i) rig.compute(1 + random() % (i == 0 ? 90000 : 900));
      rig.run(kSecond);
    }
    const server::SiteFigures got = rig.atServer();
    EXPECT_EQ(got.refused, 0u) << "seed " << seed;
    EXPECT_EQ(got.reports, 6u);
    EXPECT_GE(got.ticks + got.missed, 29000u);
    EXPECT_LE(got.ticks, rig.totals.ticks - before.ticks);
    EXPECT_GE(got.forceLimited + 200, rig.totals.forceLimited);
    EXPECT_LE(got.latest.tickMax, 90000u);
    EXPECT_GT(got.latest.tickMax, got.latest.tick50);
    EXPECT_NEAR(got.latest.roundTrip, 10000, 1000) << "of the network of the rig";
  }
}

TEST(SiteReports, SayHowLongTicksTookInTheLastPeriodOnly) {
  Reporting rig;
  for (int i = 0; i < 100000; ++i) rig.compute(80000);  // before it entered
  rig.enter();
  for (const std::int64_t time_us : {100, 20000, 300, 5000, 50}) {
    for (int i = 0; i < 5000; ++i) rig.compute(i < 4000 ? time_us : i < 4999 ? 2 * time_us : 3 * time_us);
    rig.totals.ticks += 5000;
    rig.run(kReportPeriod + 20 * kMillisecond);  // and the way to the server
    const SiteReport latest = rig.atServer().latest;
    const auto time = static_cast<double>(time_us);
    EXPECT_NEAR(latest.tick50, time, 0.07 * time + 1.0);
    EXPECT_NEAR(latest.tick99, 2.0 * time, 0.14 * time + 1.0);
    EXPECT_NEAR(latest.tickMax, 3.0 * time, 0.21 * time + 1.0);
  }
  rig.run(kReportPeriod + 20 * kMillisecond);
  EXPECT_EQ(rig.atServer().latest.tickMax, 0u) << "the loop stood still";
}

TEST(SiteReports, CountAnewWithEachConnectionAndLeaveOutWhatWasBetween) {
  Reporting rig;
  rig.enter();
  rig.totals.ticks += 5000;
  rig.run(6 * kSecond);
  EXPECT_EQ(rig.atServer().ticks, 5000u);
  rig.crash();
  rig.totals.ticks += 3600000;  // an hour
  rig.run(3 * kSecond);
  rig.start();
  rig.runUntil(ServerConnection::Stage::ready);
  rig.totals.ticks += 4000;
  rig.run(6 * kSecond);
  EXPECT_EQ(rig.atServer().ticks, 4000u);
  EXPECT_EQ(rig.atServer().refused, 0u);
}

TEST(SiteReports, AreWithinTheirBoundsWhateverTheLoopSays) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr std::int64_t kLongest = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kSecond_ns = 1000000000;
  for (const std::int64_t time_ns :
       {std::int64_t{-5}, std::int64_t{0}, 59 * kSecond_ns, 61 * kSecond_ns, kLongest})
    for (const double roundTrip_ms : {0.0, -5.0, kNaN, kInfinity, -kInfinity, 1e300, 59e3, 61e3, 0.13}) {
      SiteReports reports;
      LoopTotals totals;
      reports.setSource([&] { return totals; });
      reports.reset(0);
      haptics::DurationHistogram histogram;
      for (const std::int64_t each : {std::int64_t{1000}, time_ns}) histogram.record(each);
      totals = {5000, 3, 9000, histogram.counts()};
      ASSERT_TRUE(reports.due(kReportPeriod));
      server::SiteFigures figures;
      EXPECT_TRUE(figures.add(reports.next(kReportPeriod, roundTrip_ms), kReportPeriod))
          << time_ns << ' ' << roundTrip_ms;
      EXPECT_FALSE(reports.due(kReportPeriod)) << "once in a period";
      totals.ticks = 700;  // the loop began anew
      EXPECT_EQ(reports.next(2 * kReportPeriod, 0.0).ticks, 700u);
    }
}

TEST(HonestSite, SendsNoUpdateOfAHandThatHasNotTicked) {
  Reporting rig;
  rig.now = 1000 * kSecond;  // as a machine's clock, which began when it was started
  rig.restart();
  rig.enter();
  rig.run(kSecond);
  EXPECT_EQ(rig.session->counters().droppedMalformed, 0u);
  EXPECT_EQ(rig.session->counters().received.presence.packets, 0u);
  HandOutput ticked;
  ticked.time = rig.now;
  rig.exchange.output.write(ticked);
  rig.run(kSecond);
  EXPECT_GT(rig.session->counters().received.presence.packets, 0u);
  EXPECT_EQ(rig.session->counters().droppedMalformed, 0u);
}

TEST(SiteReports, AreNotSentBySitesWithoutALoop) {
  Reporting rig;
  rig.enter();
  rig.site->setLoopTotals({});
  rig.run(12 * kSecond);
  EXPECT_EQ(rig.atServer().reports, 0u);
}

}  // namespace
}  // namespace tandem::client
