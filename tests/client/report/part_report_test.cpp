#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "client/plot/svg_plot.h"
#include "client/plot/words.h"
#include "client/report/html.h"
#include "client/report/part_sweep.h"
#include "client/report/report_json.h"
#include "client/report/sweep.h"
#include "haptics/measure/held_depth.h"
#include "tests/support/allocation_counter.h"

namespace tandem::test {
namespace {

using namespace client::report;
using Json = nlohmann::json;

constexpr std::size_t kQuickSettings = 6;
constexpr const char* kSmall[] = {"held-slide", "held-plates"};

/// One small sweep, whose results several tests share.
const SweepResult& heldSweep() {
  static const SweepResult result = [] {
    SweepOptions options;
    options.quick = true;
    options.only = {kSmall[0], kSmall[1]};
    options.allocations = &allocationCount;
    return sweep(options);
  }();
  return result;
}

const PartMeasurement& asUsed(const std::string& id) {
  for (const PartExperimentResult& e : heldSweep().held)
    if (e.info.id == id)
      for (const PartMeasurement& m : e.settings)
        if (m.setting == "tandem") return m;
  throw std::runtime_error("no experiment " + id);
}

const PartMeasurement& settingOf(const PartExperimentResult& e, const std::string& setting) {
  for (const PartMeasurement& m : e.settings)
    if (m.setting == setting) return m;
  throw std::runtime_error("no setting " + setting);
}

double volumeOf(const assets::Scene& scene, PartId part) {
  return scene.meshes[scene.parts[part].mesh].volume;
}

TEST(PartExperiments, AreClosedSolidsOfTheSizesThatTheyName) {
  for (const ExperimentInfo& info : allPartExperiments()) {
    const PartExperiment e = buildPartExperiment(info.id, 800);
    for (const assets::Mesh& mesh : e.scene.meshes) EXPECT_TRUE(mesh.closed) << info.id;
    EXPECT_GE(e.path.size(), 800u);
  }
  const PartExperiment peg = buildPartExperiment("held-peg", 800);
  EXPECT_NEAR(static_cast<double>(peg.scene.meshes[0].triangles.size()), 20e3, 1e3);
  EXPECT_NEAR(static_cast<double>(peg.scene.meshes[1].triangles.size()), 20e3, 1e3);
  // A cylinder and the frustum of its chamfer; polygons of 320 sides have 6e-5 less.
  EXPECT_NEAR(volumeOf(peg.scene, kHeldPart), M_PI * (1e-4 * 0.039 + 1e-3 * (1e-4 + 9e-5 + 8.1e-5) / 3.0),
              2e-9);
  EXPECT_NEAR(volumeOf(peg.scene, kOtherPart), 0.03 * 0.03 * 0.045 - M_PI * 1.002e-4 * 0.04, 1e-9);
}

TEST(PartExperiments, BeginClearAndWouldGoIntoTheOtherPartAsDeepAsTheyState) {
  for (const auto& [id, depth] :
       {std::pair{"held-peg", 20e-6}, {"held-slide", 1e-3}, {"held-plates", 0.2e-3}}) {
    const PartExperiment e = buildPartExperiment(id, 400);
    const haptics::ContactScene contact(e.scene, 1);
    haptics::HeldPartDepthMeter meter(contact, kHeldPart);
    std::vector<Pose> poses{e.scene.parts[0].worldFromPart, e.scene.parts[1].worldFromPart};
    EXPECT_LT(meter.measure(poses).depth, 1e-9) << id;
    double deepest = 0.0;
    for (std::size_t i = 0; i < e.path.size(); i += id == std::string("held-plates") ? 1 : 40) {
      poses[0].position = e.path[i].goal;
      deepest = std::max(deepest, meter.measure(poses).depth);
    }
    EXPECT_GE(deepest, 0.95 * depth) << id;
  }
}

TEST(PartExperiments, GoalInAPolygonIsTheNearestPointOfIt) {
  EXPECT_EQ(insidePolygon({0.3, -0.2}, 1.0, 8), glm::dvec2(0.3, -0.2));
  std::mt19937 random(4);
  std::uniform_real_distribution<double> anywhere(-3.0, 3.0);
  for (int i = 0; i < 300; ++i) {
    const glm::dvec2 goal(anywhere(random), anywhere(random)), at = insidePolygon(goal, 1.0, 6);
    double out = -1e300, goalOut = -1e300;
    for (int k = 0; k < 6; ++k) {
      const double angle = M_PI / 3.0 * (k + 0.5);
      const glm::dvec2 n(std::cos(angle), std::sin(angle));
      out = std::max(out, glm::dot(at, n) - 1.0);
      goalOut = std::max(goalOut, glm::dot(goal, n) - 1.0);
    }
    if (goalOut <= 0.0) {
      EXPECT_EQ(at, goal);
      continue;
    }
    EXPECT_NEAR(out, 0.0, 1e-12);
    // It is the nearest point if every corner lies behind the plane through it normal to the line to the
    // goal.
    for (int k = 0; k < 6; ++k) {
      const glm::dvec2 corner =
          glm::dvec2(std::cos(k * M_PI / 3.0), std::sin(k * M_PI / 3.0)) / std::cos(M_PI / 6.0);
      EXPECT_LE(glm::dot(corner - at, goal - at), 1e-12);
    }
  }
}

TEST(PartSweep, GivesTheForceOfAnIdealPart) {
  for (const char* id : kSmall) {
    const PartMeasurement& m = asUsed(id);
    EXPECT_LT(m.error.relativeP99, 0.02) << id;
    EXPECT_LE(m.depth.max, 20e-6) << id;
    EXPECT_LE(m.forceStep.p99, 0.05) << id;
    EXPECT_GE(m.found, 0.99) << id;
    EXPECT_GT(m.cost.p50, 0.0) << id;
  }
}

TEST(PartSweep, FindsThatAPartThatNothingHoldsIsWrong) {
  // The control: the same tick on a scene without part models. The point tool still touches the floor.
  const PartExperiment e = buildPartExperiment("held-plates", 400);
  const haptics::ContactScene bare(e.scene, 1);
  PartMeasurement m;
  measureTick(e, bare, 1, 1, nullptr, m);
  EXPECT_GT(m.error.relativeP99, 0.2);
  EXPECT_GT(m.depth.max, 0.1e-3);
}

TEST(PartSweep, CountsNoHeapUseInTicks) {
  for (const PartExperimentResult& e : heldSweep().held)
    for (const PartMeasurement& m : e.settings) {
      EXPECT_TRUE(m.allocationsCounted);
      EXPECT_EQ(m.allocations, 0u) << e.info.id << ' ' << m.setting;
    }
}

TEST(PartReport, SettingsChangeWhatTheyAreNamedFor) {
  for (const PartExperimentResult& e : heldSweep().held) {
    ASSERT_EQ(e.settings.size(), kQuickSettings);
    const PartMeasurement& used = e.settings[0];
    const PartMeasurement &sparse = settingOf(e, "field-1-samples-4"),
                          &coarse = settingOf(e, "field-4-samples-1");
    EXPECT_EQ(sparse.spacing, 4.0 * used.spacing);
    EXPECT_EQ(sparse.cell, used.cell);
    EXPECT_GT(coarse.cell, 2.0 * used.cell);
    EXPECT_EQ(coarse.spacing, used.spacing);
    EXPECT_FALSE(settingOf(e, "unrefined").effort.exact);
    EXPECT_EQ(settingOf(e, "steps-1").effort.steps, 1);
    EXPECT_LT(settingOf(e, "queries-30").effort.sampleQueries, used.effort.sampleQueries);
    for (const char* less : {"unrefined", "steps-1", "queries-30"})
      EXPECT_EQ(settingOf(e, less).cell, used.cell) << less << " is of the same model";
  }
}

TEST(PartSweep, GivesTheTickTheEffortThatTheSettingNames) {
  // A field's distance from a face is off by far more than rounding.
  for (const PartExperimentResult& e : heldSweep().held) {
    const double refined = e.settings[0].error.p99, unrefined = settingOf(e, "unrefined").error.p99;
    EXPECT_GT(unrefined - refined, 1e-9) << e.info.id;
  }
}

TEST(ParetoFront, IsWhatNothingBeatsInBoth) {
  const auto at = [](double x, double y) { return PlotPoint{x, y, "", "", false}; };
  const std::vector<PlotPoint> front = paretoFront(
      {at(3.0, 1.0), at(1.0, 5.0), at(2.0, 5.0), at(2.0, 2.0), at(2.5, 3.0), at(3.0, 0.5), at(4.0, 0.5)});
  ASSERT_EQ(front.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(front[i].x, (std::array{1.0, 2.0, 3.0}[i]));
    EXPECT_EQ(front[i].y, (std::array{5.0, 2.0, 0.5}[i]));
  }
  EXPECT_TRUE(paretoFront({}).empty());
}

std::size_t countOf(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

TEST(PartReport, DrawsTheFrontAndMarksWhatIsUsedInEveryPlot) {
  SweepResult one;
  one.held.push_back(heldSweep().held[0]);
  const std::string html = htmlPage(one, "");
  EXPECT_EQ(countOf(html, "class=\"front\""), 4u) << "two errors against two costs";
  EXPECT_EQ(countOf(html, "r=\"10\" fill=\"none\""), 4u);
  EXPECT_EQ(countOf(html, ">as used</text>"), 4u);
  for (const PartMeasurement& m : one.held[0].settings)
    EXPECT_EQ(countOf(html, "<title>" + m.name + ": " + microseconds(m.cost.p50) + " p50"), 4u)
        << "every measurement is a mark of every plot";
}

TEST(PartReport, StandsOnThePageAndInTheData) {
  const std::string text = toJson(heldSweep()), html = htmlPage(heldSweep(), text);
  const Json json = Json::parse(text);
  ASSERT_EQ(json["held"].size(), 2u);
  for (const Json& e : json["held"]) {
    ASSERT_EQ(e["settings"].size(), kQuickSettings);
    EXPECT_EQ(e["settings"][0]["steps"], 4);
    EXPECT_EQ(e["settings"][0]["refined"], true);
    EXPECT_EQ(e["settings"][0]["id"], "tandem");
    for (const Json& s : e["settings"])
      for (const char* key : {"cost_us", "penetration_m", "error_n", "force_step_n", "normal_step_rad"})
        EXPECT_TRUE(s.at(key).at("p99").is_number()) << e["id"] << ' ' << key;
  }
  for (const PartExperimentResult& e : heldSweep().held)
    EXPECT_NE(html.find("<h3>" + e.info.title), std::string::npos);
  EXPECT_NE(html.find("Other libraries were not measured"), std::string::npos);
  const std::vector<Bound> bounds = boundsOf(heldSweep());
  EXPECT_EQ(std::count_if(bounds.begin(), bounds.end(),
                          [](const Bound& b) { return b.name.find("Plate on plate") == 0; }),
            6);
}

TEST(PartReport, TakesPeersFromAnotherProgramAndRefusesWhatIsNoMeasure) {
  SweepResult peers, result = heldSweep();
  peers.peers = {"Peer 1.0"};
  peers.held.push_back(result.held[0]);
  peers.held[0].settings.resize(1);
  peers.held[0].settings[0].kind = Kind::peer;
  peers.held[0].settings[0].setting = "peer";
  const std::string good = toJson(peers);
  const Result<SweepResult> read = peersFromJson(good);
  ASSERT_TRUE(read);
  mergePeers(*read, result);
  ASSERT_EQ(result.held[0].settings.size(), kQuickSettings + 1);
  EXPECT_EQ(result.held[0].settings.back().kind, Kind::peer);
  EXPECT_EQ(result.held[0].settings.back().depth.max, peers.held[0].settings[0].depth.max);
  peers.held[0].settings[0].setting = "fcl";
  mergePeers(*peersFromJson(toJson(peers)), result);
  const std::string html = htmlPage(result, "");
  EXPECT_EQ(html.find("Other libraries were not measured"), std::string::npos);
  EXPECT_NE(html.find("when the program that measures was built: Bullet, ODE"), std::string::npos);
  Json bad = Json::parse(good);
  bad["held"][0]["settings"][0]["depth_error_m"]["max"] = -1.0;
  EXPECT_FALSE(peersFromJson(bad.dump()));
}

}  // namespace
}  // namespace tandem::test
