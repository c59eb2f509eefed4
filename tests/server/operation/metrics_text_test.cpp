#include "server/operation/metrics_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <random>
#include <type_traits>

#include "tests/server/operation/prometheus_text.h"
#include "tests/server/session_rig.h"

namespace tandem::server {
namespace {

using test::PrometheusText;

PrometheusText parsed(const ServerFigures& figures) {
  const std::string text = metricsText(figures);
  auto result = PrometheusText::parse(text);
  EXPECT_TRUE(result.ok()) << result.error().message;
  return result ? *result : PrometheusText();
}

class RandomFigures {
 public:
  explicit RandomFigures(unsigned seed) : random_(seed) {}

  ServerFigures draw() {
    ServerFigures out;
    SessionCounters& counts = out.session.counters;
    for (std::uint64_t* count : {&counts.droppedStates, &counts.droppedFlood, &counts.grants, &counts.denials,
                                 &counts.holds, &counts.refusedHellos, &counts.sent.parts.bytes})
      *count = number();
    for (int i = 0; i < 50; ++i) {
      counts.journal.add(static_cast<Micros>(number() % 5000000));
      out.rounds.add(static_cast<Micros>(number() % 2000));
    }
    const std::uint64_t sites = random_() % 20;
    for (std::uint64_t i = 0; i < sites; ++i) out.session.sites.push_back(site(static_cast<SiteId>(i + 1)));
    if (random_() % 2 == 0) out.session.journalFailure = "disk \"full\"\n";
    return out;
  }

 private:
  /// Small and large numbers alike.
  std::uint64_t number() { return random_() >> (random_() % 64); }
  ConnectedSite site(SiteId id) {
    ConnectedSite out;
    out.site = id;
    out.role = static_cast<Role>(random_() % 3);
    for (std::uint64_t n = random_() % 12; n > 0; --n) out.name += pieces_[random_() % pieces_.size()];
    if (random_() % 3 == 0) return out;
    SiteFigures& figures = out.figures;
    figures.reports = 1 + number();
    for (std::uint64_t* figure : {&figures.ticks, &figures.missed, &figures.forceLimited, &figures.refused})
      *figure = number();
    SiteReport& latest = figures.latest;
    for (std::uint32_t* figure : {&latest.tick50, &latest.tick99, &latest.tickMax, &latest.roundTrip})
      *figure = static_cast<std::uint32_t>(number());
    return out;
  }

  std::mt19937_64 random_;
  const std::vector<std::string> pieces_{"\"", "\\", "\n", "{", "}",  ",",   "=",
                                         " ",  "#",  "n",  "é", "漢", "+Inf"};
};

TEST(MetricsText, IsReadBackWithEveryFigureWhateverSitesAreCalled) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const ServerFigures figures = RandomFigures(seed).draw();
    const PrometheusText text = parsed(figures);
    const SessionCounters& counts = figures.session.counters;
    EXPECT_EQ(text.value("tandem_decisions_total", {{"kind", "grant"}}), static_cast<double>(counts.grants));
    EXPECT_EQ(text.value("tandem_dropped_total", {{"reason", "over_rate"}}),
              static_cast<double>(counts.droppedFlood));
    EXPECT_EQ(text.value("tandem_journal_sound"), figures.session.journalFailure.empty() ? 1.0 : 0.0);
    EXPECT_EQ(text.value("tandem_journal_durable_seconds_count"), 50.0);
    EXPECT_NEAR(text.value("tandem_journal_durable_seconds_sum"),
                1e-6 * static_cast<double>(counts.journal.sum), 1e-6);
    for (const ConnectedSite& site : figures.session.sites) {
      const std::map<std::string, std::string> labels{{"site", std::to_string(site.site)},
                                                      {"role", toString(site.role)}};
      auto named = labels;
      named["name"] = site.name;
      EXPECT_EQ(text.value("tandem_site_info", named), 1.0) << "seed " << seed << ": " << site.name;
      const bool reported = site.figures.reports > 0;
      EXPECT_EQ(reported, !std::isnan(text.value("tandem_site_ticks_total", labels)));
      if (!reported) continue;
      EXPECT_EQ(text.value("tandem_site_ticks_total", labels), static_cast<double>(site.figures.ticks));
    }
  }
}

/// Gives every counter of a struct of them a number of its own, from `first` on.
template <typename Counters>
std::vector<std::uint64_t> numbered(Counters& counters, std::size_t bytes, std::uint64_t first) {
  static_assert(std::is_trivially_copyable_v<Counters>);
  std::vector<std::uint64_t> numbers(bytes / sizeof(std::uint64_t));
  std::iota(numbers.begin(), numbers.end(), first);
  std::memcpy(static_cast<void*>(&counters), numbers.data(), bytes);
  return numbers;
}

TEST(MetricsText, HasEveryCounterOfTheSessionAndOfTheTransport) {
  ServerFigures figures;
  SessionCounters& counters = figures.session.counters;
  std::vector<std::uint64_t> numbers = numbered(counters, offsetof(SessionCounters, journal), 100000);
  const auto more = numbered(figures.session.transport, sizeof(sync::TransportCounters), 200000);
  numbers.insert(numbers.end(), more.begin(), more.end());
  const std::string text = metricsText(figures);
  for (const std::uint64_t number : numbers)
    EXPECT_NE(text.find(' ' + std::to_string(number) + '\n'), std::string::npos)
        << "counter " << number % 100000 << (number < 200000 ? " of the session" : " of the transport");
}

TEST(MetricsText, CountsADurationInItsBucket) {
  for (std::size_t i = 0; i < DurationHistogram::kBounds.size(); ++i) {
    ServerFigures figures;
    figures.rounds.add(DurationHistogram::kBounds[i]);
    figures.rounds.add(DurationHistogram::kBounds[i] + 1);
    const auto family = parsed(figures).families().at("tandem_loop_round_seconds");
    for (std::size_t j = 0; j <= DurationHistogram::kBounds.size(); ++j)
      EXPECT_EQ(family.samples[j].value, j < i ? 0.0 : j == i ? 1.0 : 2.0) << "bound " << i << " at " << j;
  }
}

TEST(MetricsText, AgreesWithASessionAndItsDisk) {
  SessionRig rig;
  FakeSite& ada = rig.join("Ada \"\\", Role::instructor);
  FakeSite& ben = rig.join("Ben", Role::participant);
  for (RequestId i = 1; i <= 3; ++i) {
    ada.send(Grab{i, 0});
    ben.send(Grab{i, 0});
    rig.run(50 * kMillisecond);
  }
  PrometheusText text = parsed({rig.session->figures(), {}});
  EXPECT_EQ(text.value("tandem_sites", {{"role", "instructor"}}), 1.0);
  EXPECT_EQ(text.value("tandem_sites", {{"role", "participant"}}), 1.0);
  EXPECT_EQ(text.value("tandem_site_info", {{"site", "1"}, {"role", "instructor"}, {"name", "Ada \"\\"}}),
            1.0);
  EXPECT_EQ(text.value("tandem_decisions_total", {{"kind", "grant"}}),
            static_cast<double>(rig.session->counters().grants));
  EXPECT_GT(text.value("tandem_decisions_total", {{"kind", "denial"}}), 0.0);
  // The rig's disk takes 2 ms.
  const double records = text.value("tandem_journal_durable_seconds_count");
  EXPECT_GT(records, 0.0);
  EXPECT_EQ(text.value("tandem_journal_durable_seconds_bucket", {{"le", "0.001"}}), 0.0);
  EXPECT_EQ(text.value("tandem_journal_durable_seconds_bucket", {{"le", "0.005"}}), records);
  EXPECT_NEAR(text.value("tandem_journal_durable_seconds_sum"), 0.002 * records, 0.001 * records);
  EXPECT_EQ(text.value("tandem_journal_sound"), 1.0);

  rig.journal.fail("no space");
  rig.run(50 * kMillisecond);
  EXPECT_EQ(parsed({rig.session->figures(), {}}).value("tandem_journal_sound"), 0.0);
  rig.journal.heal();
  rig.run(50 * kMillisecond);
  text = parsed({rig.session->figures(), {}});
  EXPECT_EQ(text.value("tandem_journal_sound"), 1.0);
  EXPECT_GE(text.value("tandem_journal_durable_seconds_count"), records);
}

/// The negative control of the tests above.
TEST(PrometheusText, RefusesWhatAScraperWouldMisread) {
  const std::string head = "# HELP a_total A.\n# TYPE a_total counter\n";
  const std::string histogram = "# HELP h H.\n# TYPE h histogram\n";
  const auto ok = [](const std::string& text) { return PrometheusText::parse(text).ok(); };
  ASSERT_TRUE(ok(head + "a_total{b=\"\\\\ \\\" \\n\",c=\"}\"} 1\na_total 2.5e3\n"));
  ASSERT_TRUE(ok(histogram + "h_bucket{le=\"1\"} 1\nh_bucket{le=\"+Inf\"} 1\nh_sum 1\nh_count 1\n"));
  for (const char* samples : {"a_total 1",
                              "a_total 1\na_total 1\n",
                              "a_total{b=\"1\",b=\"2\"} 1\n",
                              "a_total{b=\"\\x\"} 1\n",
                              "a_total{b=\"\"\"} 1\n",
                              "a_total{b=\"1\"\n\"} 1\n",
                              "a_total{b=\"1} 1\n",
                              "a_total{b=1} 1\n",
                              "a_total{b-c=\"1\"} 1\n",
                              "a_total -1\n",
                              "a_total NaN\n",
                              "a_total +Inf\n",
                              "a_total 1 1700000000\n",
                              "a_total  1\n",
                              "a_total\n",
                              "a_total 0x10\n",
                              "b_total 1\n",
                              "a_total 1\n\n",
                              "# a comment\n",
                              "# TYPE a_total counter\n",
                              "# HELP a_total A.\n# TYPE a_total counter\n",
                              "# HELP b_total B.\nb_total 1\n"})
    EXPECT_FALSE(ok(head + samples)) << samples;
  EXPECT_FALSE(ok("a_total 1\n"));
  EXPECT_FALSE(ok("# HELP a A.\n# TYPE a counter\na 1\n"));
  EXPECT_FALSE(ok("# HELP a_total A.\n# TYPE a_total gauge\na_total 1\n"));
  for (const char* samples :
       {"h_bucket{le=\"1\"} 1\nh_sum 1\nh_count 1\n",
        "h_bucket{le=\"1\"} 2\nh_bucket{le=\"+Inf\"} 1\nh_sum 1\nh_count 1\n",
        "h_bucket{le=\"2\"} 1\nh_bucket{le=\"1\"} 1\nh_bucket{le=\"+Inf\"} 1\nh_sum 1\nh_count 1\n",
        "h_bucket{le=\"1\"} 1\nh_bucket{le=\"+Inf\"} 1\nh_sum 1\nh_count 2\n",
        "h_bucket{le=\"1\"} 1\nh_bucket{le=\"+Inf\"} 1\nh_count 1\n",
        "h_bucket 1\nh_bucket{le=\"+Inf\"} 1\nh_sum 1\nh_count 1\n", "h 1\n"})
    EXPECT_FALSE(ok(histogram + samples)) << samples;
}

}  // namespace
}  // namespace tandem::server
