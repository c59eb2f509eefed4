#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "assets/generate/bench_meshes.h"
#include "assets/generate/profile_god_object.h"
#include "client/plot/svg_plot.h"
#include "client/report/exact_answers.h"
#include "client/report/html.h"
#include "client/report/report_json.h"
#include "client/report/sweep.h"
#include "tests/client/report/report_checks.h"
#include "tests/support/allocation_counter.h"

namespace tandem::test {
namespace {

using namespace client::report;
using generate::insideProfile;
using generate::ProfileGodObject;
using Json = nlohmann::json;

/// One small sweep, whose results several tests share.
const SweepResult& smallSweep() {
  static const SweepResult result = [] {
    SweepOptions options;
    options.quick = true;
    options.only = {"sphere-1k", "sphere-10k", "gear-1k", "plane", "groove"};
    options.allocations = &allocationCount;
    return sweep(options);
  }();
  return result;
}

const ExperimentResult& experiment(const std::string& id) {
  for (const ExperimentResult& e : smallSweep().experiments)
    if (e.info.id == id) return e;
  throw std::runtime_error("no experiment " + id);
}

const Measurement& setting(const std::string& experimentId, const std::string& id) {
  for (const Measurement& m : experiment(experimentId).settings)
    if (m.setting == id) return m;
  throw std::runtime_error("no setting " + id);
}

TEST(ProfileGodObject, RestsOnTheSideOfAnOutlineFromWhichItCame) {
  const std::vector<glm::dvec2> square{{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> across(-0.99, 0.99), deep(-0.99, 1.5);
  for (int i = 0; i < 1000; ++i) {
    ProfileGodObject object(square);
    const glm::dvec2 goal(across(random), deep(random));
    object.place({goal.x, 4.0});
    const glm::dvec2 at = object.follow(goal);
    EXPECT_NEAR(at.x, goal.x, 1e-15);
    EXPECT_NEAR(at.y, std::max(goal.y, 1.0),
                1e-15);  // never on the bottom side, however near the goal is to it
  }
}

TEST(ProfileGodObject, StopsInAConcaveCornerAndLeavesItAgain) {
  // An L: its inner corner is at the origin, the free space is the first quadrant there.
  const std::vector<glm::dvec2> corner{{-2.0, -2.0}, {3.0, -2.0}, {3.0, 0.0},
                                       {0.0, 0.0},   {0.0, 3.0},  {-2.0, 3.0}};
  ProfileGodObject object(corner);
  object.place({1.0, 1.0});
  const glm::dvec2 goals[] = {{-0.3, -0.2}, {0.5, -0.2}, {-0.2, 0.7}, {0.4, 0.7}};
  const glm::dvec2 places[] = {{0.0, 0.0}, {0.5, 0.0}, {0.0, 0.7}, {0.4, 0.7}};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(glm::length(object.follow(goals[i]) - places[i]), 0.0, 1e-15) << i;
}

glm::dvec2 nearestOnProfile(const std::vector<glm::dvec2>& loop, const glm::dvec2& p) {
  glm::dvec2 nearest(1e300);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const glm::dvec2 a = loop[i], d = loop[(i + 1) % loop.size()] - a;
    const glm::dvec2 q = a + d * std::clamp(glm::dot(p - a, d) / glm::dot(d, d), 0.0, 1.0);
    if (glm::length(q - p) < glm::length(nearest - p)) nearest = q;
  }
  return nearest;
}

TEST(ProfileGodObject, GoesWhereTinyStepsOfBruteForceGo) {
  // Brute force: steps of 5 um towards the goal, put back onto the outline wherever they enter the solid.
  const std::vector<glm::dvec2> profile = generate::gearProfile();
  ProfileGodObject object(profile);
  glm::dvec2 crawler(0.0241, 0.0);
  object.place(crawler);
  int free = 0;
  double longest = 0.0;
  for (int tick = 0; tick < 40; ++tick) {
    const double angle = 0.014 * tick;
    const double radius = 0.0226 + 0.0015 * std::cos(0.5 * tick);  // a tooth ends at 0.0233
    const glm::dvec2 goal(radius * std::cos(angle), radius * std::sin(angle));
    const glm::dvec2 before = crawler;
    for (int i = 0; i < 5000 && crawler != goal; ++i) {
      const glm::dvec2 displacement = goal - crawler;
      const glm::dvec2 there = crawler + displacement * std::min(1.0, 5e-6 / glm::length(displacement));
      const glm::dvec2 last = crawler;
      crawler = insideProfile(profile, there) ? nearestOnProfile(profile, there) : there;
      if (glm::length(crawler - last) < 1e-9) break;
    }
    const glm::dvec2 exact = object.follow(goal);
    EXPECT_NEAR(glm::length(crawler - exact), 0.0, 5e-6) << tick;
    free += exact == goal ? 1 : 0;
    longest = std::max(longest, glm::length(crawler - before));
  }
  // The path contained the hard cases: contact, free space, and a snap round a corner.
  EXPECT_GT(free, 3);
  EXPECT_LT(free, 37);
  EXPECT_GT(longest, 1e-3);  // the hand goes 0.8 mm a tick at most
}

TEST(GrownProfile, LiesABallsRadiusOffTheOutline) {
  const std::vector<glm::dvec2> profile = generate::gearProfile();
  for (const glm::dvec2& p : generate::grownProfile(profile, 1e-3, 1e-2)) {
    EXPECT_FALSE(insideProfile(profile, p));
    EXPECT_NEAR(glm::length(nearestOnProfile(profile, p) - p), 1e-3, 1e-12) << p.x << ' ' << p.y;
  }
}

TEST(ExactAnswers, LieOnTheSurfaceNearestToTheGoal) {
  EXPECT_EQ(outsideSphere({0.0, 3.0, 0.0}, 2.0), glm::dvec3(0.0, 3.0, 0.0));
  EXPECT_EQ(outsideSphere({0.0, 1.0, 0.0}, 2.0), glm::dvec3(0.0, 2.0, 0.0));
  EXPECT_EQ(abovePlane({1.0, 2.0, -3.0}, 0.5), glm::dvec3(1.0, 2.0, 0.5));
  const double half = 0.5;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-1.0, 1.0);
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 goal(anywhere(random), anywhere(random), anywhere(random));
    const glm::dvec3 at = insideGroove(goal, half);
    double nearest = 1e300;
    for (int k = 0; k <= 4000; ++k) {
      const double up = k / 2000.0;
      for (int side = -1; side <= 1; side += 2)
        nearest = std::min(
            nearest, glm::length(glm::dvec3(side * up * std::sin(half), goal.y, up * std::cos(half)) - goal));
    }
    const bool free = std::abs(goal.x) * std::cos(half) <= goal.z * std::sin(half);
    // No sample is nearer, and the nearest of them, 0.5 mm apart, is hardly farther.
    EXPECT_LE(glm::length(at - goal), free ? 0.0 : nearest + 1e-15);
    EXPECT_NEAR(glm::length(at - goal), free ? 0.0 : nearest, 3e-4);
  }
}

TEST(Sweep, StaysWithinWhatFacetsMayCost) {
  for (const char* id : {"sphere-1k", "sphere-10k"}) {
    EXPECT_LE(setting(id, "tandem").error.max, experiment(id).facetError);
    EXPECT_GT(setting(id, "tandem").error.max, 0.01 * experiment(id).facetError);
  }
  EXPECT_LT(setting("sphere-10k", "tandem").error.p99, 0.5 * setting("sphere-1k", "tandem").error.p99);
}

TEST(Sweep, IsExactOnFlatWallsWhereABaselineOfOnePlaneATickIsNot) {
  for (const char* id : {"plane", "groove", "gear-1k"}) {
    EXPECT_LE(setting(id, "tandem").error.relativeP99, 1e-6) << id;
    EXPECT_GE(setting(id, "one-plane-double").error.relativeP99, 0.02) << id;
  }
  // The proxy stands still every second tick: at 0.5 m/s that is 0.5 mm of lag, a quarter of the depth of 2
  // mm.
  EXPECT_NEAR(setting("plane", "one-plane-double").error.relativeMax, 0.25, 0.01);
  EXPECT_LE(setting("plane", "three-planes-double").error.relativeP99, 1e-6);
}

TEST(Sweep, ShowsThatSinglePrecisionIsWorse) {
  EXPECT_GE(setting("plane", "three-planes-float").error.p99,
            100.0 * setting("plane", "three-planes-double").error.p99);
  EXPECT_GE(setting("gear-1k", "float-data").error.p99, 5.0 * setting("gear-1k", "tandem").error.p99);
}

TEST(Sweep, CountsNoHeapUseInTicks) {
  for (const ExperimentResult& e : smallSweep().experiments)
    for (const Measurement& m : e.settings) {
      if (m.kind != Kind::tandem) continue;
      EXPECT_TRUE(m.allocationsCounted);
      EXPECT_EQ(m.allocations, 0u) << e.info.id << ' ' << m.setting;
    }
}

/// Whether a JSON value holds no null: numbers that are not finite are written as null.
void expectNoNull(const Json& json, const std::string& where) {
  if (json.is_structured()) {
    for (const auto& [key, value] : json.items()) expectNoNull(value, where + "/" + key);
  } else {
    EXPECT_FALSE(json.is_null() && !where.ends_with("allocations")) << where;
  }
}

TEST(Report, WritesEverySceneAndSettingAsJson) {
  const Json json = Json::parse(toJson(smallSweep()));
  expectNoNull(json, "");
  ASSERT_EQ(json["experiments"].size(), 5u);
  for (const Json& e : json["experiments"]) {
    std::vector<std::string> ids;
    for (const Json& s : e["settings"]) ids.push_back(s["id"]);
    for (const char* id : {"tandem", "no-memory", "float-data", "three-planes-double", "one-plane-double",
                           "three-planes-float", "one-plane-float"})
      EXPECT_NE(std::find(ids.begin(), ids.end(), id), ids.end()) << e["id"] << ' ' << id;
    EXPECT_GT(e["settings"][0]["cost_us"]["p50"], 0.0);
  }
}

TEST(Report, IsOnePageThatNeedsNothingElse) {
  const std::string json = toJson(smallSweep()), html = htmlPage(smallSweep(), json);
  expectBalanced(html);
  for (const ExperimentResult& e : smallSweep().experiments)
    for (const Measurement& m : e.settings) {
      EXPECT_NE(html.find(escaped(e.info.title)), std::string::npos);
      EXPECT_NE(html.find(escaped(m.name)), std::string::npos);
    }
  for (const char* outside : {"href=", "src=", "@import", "url("})
    EXPECT_EQ(html.find(outside), std::string::npos);
  const std::string page = html.substr(0, html.find("<script"));
  for (const char* bad : {">nan", ">inf", "\"nan", "nan\"", "-nan", " inf "})
    EXPECT_EQ(page.find(bad), std::string::npos) << bad;
  const std::size_t from = html.find("id=\"data\">") + 10;
  EXPECT_EQ(Json::parse(html.substr(from, html.find("</script>", from) - from)), Json::parse(json));
  EXPECT_NE(html.find("Peers were not measured"), std::string::npos);
}

TEST(Report, KeepsHostileTextOutOfItsMarkup) {
  SweepResult result = smallSweep();
  result.machine = "</script><script>alert(1)</script>";
  result.experiments[0].settings[0].name = "<b>&\"";
  const std::string html = htmlPage(result, toJson(result));
  expectBalanced(html);
  EXPECT_EQ(html.find("<script>alert"), std::string::npos);
  const std::size_t from = html.find("id=\"data\">") + 10;
  EXPECT_EQ(Json::parse(html.substr(from, html.find("</script>", from) - from))["machine"], result.machine);
}

TEST(Report, TakesPeersFromAnotherProgramAndRefusesWhatIsNoMeasure) {
  SweepResult result = smallSweep(), peers;
  peers.peers = {"Peer 1.0"};
  peers.experiments.push_back(result.experiments[0]);
  peers.experiments[0].settings.resize(1);
  peers.experiments[0].settings[0].setting = "peer";
  const std::string good = toJson(peers);
  const Result<SweepResult> read = peersFromJson(good);
  ASSERT_TRUE(read);
  const std::size_t before = result.experiments[0].settings.size();
  mergePeers(*read, result);
  ASSERT_EQ(result.experiments[0].settings.size(), before + 1);
  EXPECT_EQ(result.experiments[0].settings.back().kind, Kind::peer);
  EXPECT_EQ(result.experiments[0].settings.back().cost.p50, peers.experiments[0].settings[0].cost.p50);
  EXPECT_NE(htmlPage(result, toJson(result)).find("Peer 1.0"), std::string::npos);
  Json bad = Json::parse(good);
  bad["experiments"][0]["settings"][0]["cost_us"]["p50"] = -1.0;
  for (const std::string& text :
       {bad.dump(), std::string("[]"), std::string("{"), std::string("{\"peers\":3}")})
    EXPECT_FALSE(peersFromJson(text)) << text;
}

TEST(SvgPlot, MarksWhatIsTooSmallToBeDrawnWhereItIs) {
  ScatterPlot plot;
  plot.series = {{{"a", "#112233"}, {{1.0, 1e-12, "", ""}, {2.0, 1e-9, "", ""}, {3.0, 2e-9, "", ""}}}};
  const std::string svg = scatterSvg(plot);
  EXPECT_EQ(countOf(svg, "class=\"below\""), 2u);
  EXPECT_EQ(countOf(svg, ">≤ 10⁻⁹<") + countOf(svg, ">≤ 1·10⁻⁹<"), 1u);
  plot.series[0].points = {{1.0, 1e-6, "", ""}, {3.0, 2e-9, "", ""}};
  EXPECT_EQ(countOf(scatterSvg(plot), "≤"), 0u);
  EXPECT_EQ(countOf(scatterSvg(plot), "class=\"below\""), 0u);
}

TEST(SvgPlot, NoLabelLiesOnAMarkerOrAnotherLabel) {
  // Points of three sizes, nearly at one place, with lines through them.
  ScatterPlot plot;
  plot.series = {
      {{"a", "#112233"}, {{1.0, 1e-3, "1 k", ""}, {1.02, 1e-3, "10 k", ""}, {1.3, 1e-3, "100 k", ""}}},
      {{"b", "#332211"}, {{1.0, 1.2e-3, "", ""}, {1.2, 0.8e-3, "", ""}, {100.0, 1.0, "", ""}}}};
  const std::string svg = scatterSvg(plot);
  std::vector<std::array<double, 4>> boxes;  // left, top, right, bottom
  for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1)) {
    double x = 0.0, y = 0.0;
    ASSERT_EQ(std::sscanf(svg.c_str() + at, "<circle cx=\"%lf\" cy=\"%lf\"", &x, &y), 2);
    boxes.push_back({x - 5.0, y - 5.0, x + 5.0, y + 5.0});
  }
  for (const char* label : {"1 k", "10 k", "100 k"}) {
    const std::size_t end = svg.find(std::string(">") + label + "<");
    ASSERT_NE(end, std::string::npos);
    double x = 0.0, y = 0.0;
    ASSERT_EQ(std::sscanf(svg.c_str() + svg.rfind("<text", end), "<text x=\"%lf\" y=\"%lf\"", &x, &y), 2);
    const double half = 3.0 * static_cast<double>(std::string(label).size());
    const std::array<double, 4> box{x - half, y - 8.0, x + half, y};
    for (const std::array<double, 4>& other : boxes)
      EXPECT_FALSE(box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3])
          << label << " at " << x << ' ' << y;
    boxes.push_back(box);
  }
}

}  // namespace
}  // namespace tandem::test
