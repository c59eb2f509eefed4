#include "server/site_figures.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "server/operation/metrics_text.h"
#include "tests/server/operation/prometheus_text.h"
#include "tests/server/session_rig.h"

namespace tandem::server {
namespace {

constexpr std::uint32_t kAll = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kMostTime = static_cast<std::uint32_t>(kMaxReportedTime);

SiteReport honest() {
  SiteReport report;
  report.ticks = 4990;
  report.missed = 12;
  report.forceLimited = 40;
  report.tick50 = 60;
  report.tick99 = 180;
  report.tickMax = 2400;
  report.roundTrip = 21000;
  return report;
}

/// Reports that cannot be true, each by another figure.
std::vector<SiteReport> lies(std::mt19937& random) {
  const auto beyond = [&](std::uint32_t bound) { return bound + 1 + random() % (kAll - bound - 1); };
  std::vector<SiteReport> all(9, honest());
  all[0].ticks = beyond(100000);
  all[1].missed = beyond(100000);
  all[2].forceLimited = beyond(all[2].ticks);
  all[3].tick50 = beyond(all[3].tick99);
  all[4].tick99 = beyond(all[4].tickMax);
  all[5].tickMax = beyond(kMostTime);
  all[6].roundTrip = beyond(kMostTime);
  all[7] = {kAll, kAll, kAll, kAll, kAll, kAll, kAll};
  all[8] = {0, 0, 1, 0, 0, 0, 0};
  return all;
}

TEST(SiteFigures, RefusesEachReportThatCannotBeTrueWholeAndCountsIt) {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round)
    for (const SiteReport& lie : lies(random)) {
      SiteFigures figures;
      figures.since = kSecond;
      ASSERT_TRUE(figures.add(honest(), 6 * kSecond));
      const SiteFigures before = figures;
      EXPECT_FALSE(figures.add(lie, 11 * kSecond));
      EXPECT_EQ(figures.refused, 1u);
      EXPECT_EQ(figures.ticks, before.ticks);
      EXPECT_EQ(figures.missed, before.missed);
      EXPECT_EQ(figures.latest.tickMax, before.latest.tickMax);
      EXPECT_EQ(figures.latest.roundTrip, before.latest.roundTrip);
      EXPECT_TRUE(figures.add(honest(), 11 * kSecond)) << "and takes the next one that can";
    }
}

TEST(SiteFigures, TakesReportsThatANetworkDeliversTogether) {
  for (const int together : {1, 2, 5, 12}) {
    SiteFigures figures;
    for (int sent = together; sent <= 120; sent += together)
      for (int i = 0; i < together; ++i)
        EXPECT_TRUE(figures.add(honest(), sent * kReportPeriod)) << together << " at " << sent;
    EXPECT_EQ(figures.reports, 120u);
  }
}

TEST(SiteFigures, OfALiarStayWithinBoundsAndNobodyElsesChange) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    std::mt19937 random(seed);
    SessionRig rig;
    FakeSite& ada = rig.join("Ada");
    FakeSite& eve = rig.join("Eve");
    const Micros began = rig.now;
    const Micros pause = std::vector<Micros>{20, 100, 700}[random() % 3] * kMillisecond;
    std::uint64_t reports = 0;
    for (Micros next = began + kReportPeriod; rig.now < began + 21 * kSecond;) {
      SiteReport report = honest();
      if (random() % 2 == 0) report.ticks = random() % 40000;  // which may be true, once
      const auto all = lies(random);
      eve.send(random() % 2 == 0 ? report : all[random() % all.size()]);
      rig.run(pause);
      if (rig.now < next) continue;
      next += kReportPeriod;
      ada.send(honest());
      ++reports;
    }
    rig.run(100 * kMillisecond);
    const double most = SiteFigures::kMostTicks * toSeconds(rig.now - began + SiteFigures::kSlack);
    const SessionFigures figures = rig.session->figures();
    const auto text = test::PrometheusText::parse(metricsText({figures, {}}));
    ASSERT_TRUE(text.ok()) << text.error().message;
    const auto of = [&](const char* name, const char* site) {
      return text->value(std::string("tandem_site_") + name, {{"site", site}, {"role", "participant"}});
    };
    EXPECT_EQ(of("ticks_total", "1"), static_cast<double>(reports * honest().ticks)) << "seed " << seed;
    EXPECT_EQ(of("reports_refused_total", "1"), 0.0);
    EXPECT_LE(of("ticks_total", "2"), most) << "seed " << seed;
    EXPECT_LE(of("ticks_missed_total", "2"), most);
    EXPECT_LE(of("ticks_force_limited_total", "2"), of("ticks_total", "2"));
    EXPECT_LE(of("round_trip_seconds", "2"), 60.0);
    EXPECT_GT(of("reports_refused_total", "2"), 0.0);
    EXPECT_EQ(text->value("tandem_refused_total", {{"what", "report"}}), of("reports_refused_total", "2"));
    EXPECT_FALSE(ada.closed || eve.closed) << "a report parts nobody from the session";
  }
}

}  // namespace
}  // namespace tandem::server
