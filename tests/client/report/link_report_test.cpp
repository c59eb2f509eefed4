// The report on two sites that share a part, checked against runs of the bench itself, physics, and
// architectures that must fail.

#include <gtest/gtest.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "client/plot/panel_plot.h"
#include "client/report/html.h"
#include "client/report/link_page.h"
#include "client/report/link_recording.h"
#include "client/report/link_sweep.h"
#include "client/report/report_json.h"
#include "client/report/sweep.h"
#include "tests/client/report/report_checks.h"

namespace tandem::test {
namespace {

using namespace client::report;
using Json = nlohmann::json;

LinkSetting inUse() {
  LinkSetting s;
  s.id = "link";
  s.inUse = true;
  return s;
}

LinkSetting tiedBy(Architecture architecture, const SpringGains& gains) {
  LinkSetting s;
  s.architecture = architecture;
  s.gains = gains;
  return s;
}

double inSeries(std::initializer_list<double> stiffnesses) {
  double sum = 0.0;
  for (const double k : stiffnesses) sum += 1.0 / k;
  return 1.0 / sum;
}

constexpr double kGraspStiffness = bench::kGrasp.stiffness, kWallStiffness = 5000.0;  // N/m

TEST(LinkReport, MeasuresTheLinkAsARunOfTheBenchDoes) {
  bench::BenchSetup setup;
  setup.network.delay = 0.05;
  setup.sites = bench::twoHands(bench::firmArm(), bench::lightArm());
  const bench::DragFigures dragged = bench::drag(setup, {.until = 8.0});
  setup.sites = bench::twoHands(bench::firmArm(), bench::firmArm());
  const bench::PullFigures pulled = bench::pull(setup, bench::LetGo::nobody);
  setup.sites = bench::twoHands(bench::lightArm(), bench::relaxedArm());
  const bench::PressFigures pressed = bench::press(setup);

  const LinkMeasurement m = measureLink(inUse(), 0.05, 1, 2.0);
  EXPECT_EQ(m.apart, dragged.rms);
  EXPECT_EQ(m.load, dragged.load / 2.0);
  EXPECT_EQ(m.handToHand, pulled.stiffness);
  EXPECT_EQ(m.wall, pressed.stiffness);
  EXPECT_TRUE(m.stable());
  // The control: with another impedance, margin or rate the figures differ.
  LinkSetting other = inUse();
  other.inUse = false;
  other.impedance = 14.0;
  EXPECT_LT(measureLink(other, 0.05, 1, 2.0).handToHand, 0.9 * m.handToHand);
  other.impedance = 27.0;
  EXPECT_EQ(measureLink(other, 0.05, 1, 2.0).apart, m.apart);
  other.margin = 0.02;
  EXPECT_NEAR(measureLink(other, 0.05, 1, 2.0).playOut, m.playOut + 0.02, 1e-12);
}

TEST(LinkReport, FeelsSpringsInSeries) {
  const LinkMeasurement alone = measureLink(tiedBy(Architecture::oneRoom, {}), 0.05, 1, 0.0);
  EXPECT_EQ(alone.apart, 0.0);
  EXPECT_NEAR(alone.handToHand, inSeries({kGraspStiffness, kGraspStiffness}), 15.0);
  EXPECT_NEAR(alone.wall, inSeries({kGraspStiffness, kWallStiffness}), 5.0);
  const LinkMeasurement plain = measureLink(tiedBy(Architecture::plain, {100.0, 5.0}), 0.01, 1, 0.0);
  EXPECT_NEAR(plain.handToHand, inSeries({kGraspStiffness, 100.0, kGraspStiffness}), 1.0);
  const LinkMeasurement server = measureLink(tiedBy(Architecture::server, {40.0, 2.0}), 0.01, 1, 0.0);
  EXPECT_NEAR(server.handToHand, inSeries({40.0, 40.0}), 0.5);
  EXPECT_NEAR(server.wall, inSeries({40.0, kWallStiffness}), 2.0);
}

TEST(LinkReport, WhatMustFailFails) {
  const LinkMeasurement plain = measureLink(tiedBy(Architecture::plain, {400.0, 5.0}), 0.05, 1, 0.0);
  EXPECT_TRUE(plain.diverged);
  EXPECT_FALSE(plain.stable());
  EXPECT_GT(plain.created, 0.1);
  const LinkMeasurement server = measureLink(tiedBy(Architecture::server, {400.0, 5.0}), 0.05, 1, 0.0);
  EXPECT_FALSE(server.stable());
}

TEST(LinkReport, TankHoldsWhatThePlainSpringDoesNot) {
  // It creates no more energy than the tanks hold at the start, however rough it is.
  const LinkMeasurement tank = measureLink(tiedBy(Architecture::tank, {400.0, 5.0}), 0.05, 1, 0.0);
  EXPECT_FALSE(tank.diverged);
  EXPECT_LE(tank.created, 0.02);
  EXPECT_NEAR(tank.handToHand, inSeries({kGraspStiffness, 400.0, kGraspStiffness}), 5.0);
}

TEST(LinkReport, BestGainsOfOthersAreStableAndThreeTimesAsStiffWouldNotDo) {
  const double alone = loadWithoutNetwork();
  for (const Architecture architecture : {Architecture::plain, Architecture::tank, Architecture::server}) {
    const SpringGains gains = knownGains(architecture, 0.025);
    if (!(gains.stiffness > 0.0)) continue;
    LinkSetting setting = tiedBy(architecture, gains);
    setting.letsGo = true;
    const LinkMeasurement best = measureLink(setting, 0.025, 1, alone);
    EXPECT_TRUE(best.stable());
    EXPECT_LE(best.load, 2.0);
    setting.gains.stiffness *= 3.0;
    const LinkMeasurement stiffer = measureLink(setting, 0.025, 1, alone);
    EXPECT_TRUE(!stiffer.stable() || stiffer.load > 2.0) << gains.stiffness;
  }
  EXPECT_GT(knownGains(Architecture::plain, 0.025).stiffness, 0.0);  // a search has found gains
}

TEST(LinkReport, CountsTheBytesOfTheWire) {
  // 39 bytes, every eighth time 70, and 32 of the seal.
  const double bytes = 39.0 + (70.0 - 39.0) / 8.0 + 32.0;
  EXPECT_NEAR(measureLink(inUse(), 0.025, 1, 0.0).bytes, 250.0 * bytes, 50.0);
  LinkSetting slower = inUse();
  slower.packetHz = 60.0;
  EXPECT_NEAR(measureLink(slower, 0.025, 1, 0.0).bytes, 60.0 * bytes, 50.0);
}

TEST(LinkReport, TimesWhatItRecorded) {
  const auto recording = std::make_shared<LinkRecording>();
  const bench::LinkEndMaker make = [](const haptics::LinkParameters& p, double delay) {
    return std::make_unique<bench::CoordinationLinkEnd>(p, delay);
  };
  bench::BenchSetup setup;
  setup.sites = bench::twoHands(bench::firmArm(), bench::lightArm());
  setup.makeEnd = recordingFirst(make, recording);
  bench::drag(setup, {.until = 4.0});
  ASSERT_EQ(recording->ticks.size(), 4000u);
  bench::CoordinationLinkEnd again(setup.link, setup.network.delay);
  replay(*recording, again);
  // A fresh end with the same input gives the same packet.
  const haptics::LinkPacket packet = again.packet(4.0);
  EXPECT_EQ(packet.sequence, recording->sent.size());
  setup.makeEnd = make;
  bench::LinkBench bench(setup);
  bench.runTo(4.0, [](double t, int who) { return who == 0 ? bench::dragPath(t) : haptics::SixAxes{}; });
  EXPECT_EQ(again.account().work, bench.end(0, 0).account().work);
  EXPECT_GT(tickCost(inUse(), 0.025), 0.0);
}

/// A quick sweep at one delay at which the plain spring is unstable.
const SweepResult& linkSweep() {
  static const SweepResult result = [] {
    SweepOptions options;
    options.quick = true;
    options.only = {"link-50ms"};
    return sweep(options);
  }();
  return result;
}

const Json* linkSettingOf(const Json& experiment, const std::string& id) {
  for (const Json& s : experiment["settings"])
    if (s["id"] == id) return &s;
  return nullptr;
}

TEST(LinkReport, WritesEverySettingAsJsonAndNoFigureOfWhatDiverged) {
  const Json json = Json::parse(toJson(linkSweep()));
  ASSERT_EQ(json["links"].size(), 1u);
  const Json& e = json["links"][0];
  EXPECT_EQ(e["one_way_s"], 0.05);
  for (const char* id : {"link", "no-network", "plain-400", "plain-best", "tank-best", "server-best",
                         "link-60hz-margin0ms-b27", "link-500hz-margin0ms-b27", "link-250hz-margin-5ms-b27",
                         "link-250hz-margin10ms-b27", "link-250hz-margin0ms-b7", "link-250hz-margin0ms-b40"})
    EXPECT_NE(linkSettingOf(e, id), nullptr) << id;
  const Json& link = *linkSettingOf(e, "link");
  const LinkMeasurement direct = measureLink(inUse(), 0.05, 1, loadWithoutNetwork());
  EXPECT_EQ(link["apart_m"]["rms"], direct.apart);
  EXPECT_EQ(link["hand_to_hand_n_m"], direct.handToHand);
  EXPECT_EQ(link["leader_force_ratio"], direct.load);
  EXPECT_EQ(link["stable"], true);
  EXPECT_GT(link["tick_cost"], 0.0);
  const Json& plain = *linkSettingOf(e, "plain-400");
  EXPECT_EQ(plain["stable"], false);
  EXPECT_TRUE(plain["diverged"]);
  EXPECT_TRUE(plain["apart_m"]["rms"].is_null());
  EXPECT_GT(plain["created_j"], 0.1);
}

TEST(LinkReport, PageShowsUnstableAsUnstable) {
  const std::string html = htmlPage(linkSweep(), toJson(linkSweep()));
  expectBalanced(html);
  EXPECT_NE(html.find("Across the network"), std::string::npos);
  EXPECT_NE(html.find("class=\"missed\">diverges"), std::string::npos);
  EXPECT_GE(countOf(html, "class=\"unstable\""), 4u);
  const std::string page = html.substr(0, html.find("<script"));
  for (const char* bad : {">nan", ">inf", "\"nan", "nan\"", "-nan", " inf ", " nan "})
    EXPECT_EQ(page.find(bad), std::string::npos) << bad;
  // The control: without unstable settings there is no cross.
  SweepResult calm = linkSweep();
  std::erase_if(calm.links[0].settings, [](const LinkMeasurement& m) { return !m.stable(); });
  EXPECT_EQ(countOf(linkSection(calm), "class=\"unstable\""), 0u);
}

TEST(LinkReport, JudgesTheLinkByWhatIsAsked) {
  const auto missed = [](const LinkExperimentResult& e) {
    std::vector<Bound> bounds;
    linkBounds(e, bounds);
    EXPECT_EQ(bounds.size(), 6u);
    return std::count_if(bounds.begin(), bounds.end(), [](const Bound& b) { return !b.met(); });
  };
  LinkExperimentResult e = linkSweep().links[0];
  EXPECT_EQ(missed(e), 0);
  for (LinkMeasurement& m : e.settings)
    if (m.setting.inUse) m.handToHand = 100.0, m.created = 2e-3;
  EXPECT_EQ(missed(e), 2);
}

TEST(PanelPlot, DrawsCrossesForWhatIsUnstableAndArrowsForWhatIsLess) {
  Panel panel{"title", "x", "y", 0.1, {10.0, 100.0}, {}};
  panel.series.push_back(
      {{"a", "#112233"}, {{10.0, 1.0, "", ""}, {100.0, 0.01, "", ""}}, {{100.0, 0.0, "", ""}}, true});
  const std::string svg = panelsSvg({panel, panel});
  EXPECT_EQ(countOf(svg, "class=\"unstable\""), 2u);
  EXPECT_EQ(countOf(svg, "class=\"below\""), 2u);
  EXPECT_EQ(countOf(svg, ">a</text>"), 1u);  // one legend
}

}  // namespace
}  // namespace tandem::test
