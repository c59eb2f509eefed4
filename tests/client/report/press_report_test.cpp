// Irregular parts pressed onto each other, as the report measures them, and cost by the rows of the contact.

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "client/report/html.h"
#include "client/report/part_sweep.h"
#include "client/report/press_sweep.h"
#include "client/report/report_json.h"
#include "client/report/sweep.h"
#include "haptics/measure/penetration.h"
#include "tests/client/report/report_checks.h"
#include "tests/support/allocation_counter.h"

namespace tandem::test {
namespace {

using namespace client::report;
using generate::Family;

const SweepResult& pressSweep() {
  static const SweepResult result = [] {
    SweepOptions options;
    options.quick = true;
    options.only = {"press-blobs"};
    options.allocations = &allocationCount;
    return sweep(options);
  }();
  return result;
}

const PressMeasurement& pressSetting(const std::string& setting) {
  for (const PressMeasurement& m : pressSweep().presses.at(0).settings)
    if (m.figures.setting == setting) return m;
  throw std::runtime_error("no setting " + setting);
}

TEST(PressExperiments, BeginApartAndLeadOnePartIntoTheOther) {
  for (const Family family : {Family::blobs, Family::blocks, Family::turned}) {
    const PartExperiment e = buildPress(family, 0, 1);
    const haptics::DepthModel held(e.scene.meshes[0]), other(e.scene.meshes[1]);
    const Pose& start = e.scene.parts[kHeldPart].worldFromPart;
    const auto depthAt = [&](const PartPathPoint& p) {
      return haptics::deepestPenetration(held, {p.goal, p.turned * start.orientation}, other,
                                         e.scene.parts[kOtherPart].worldFromPart)
          .depth;
    };
    EXPECT_EQ(depthAt(e.path.front()), 0.0);
    EXPECT_GT(depthAt(e.path[180]), 0.5e-3) << "the hand has pressed by 2 mm";
    EXPECT_GT(glm::distance(e.path[180].goal, e.path.back().goal), 9e-3) << "and slides";
  }
}

TEST(PressSweep, GoesNoDeeperThanIsAskedWhereTheSamplesAloneDo) {
  const PressMeasurement &used = pressSetting("tandem"), &alone = pressSetting("samples-alone");
  EXPECT_LE(used.figures.depth.max, pressSweep().presses[0].targetDepth);
  EXPECT_EQ(used.beyond, 0);
  EXPECT_GT(alone.figures.depth.max, 2.0 * used.figures.depth.max);
  EXPECT_GT(alone.beyond, 0);
  EXPECT_LE(used.figures.forceChange.p99, 0.05);
  EXPECT_EQ(pressSetting("field-1-samples-4").figures.spacing, 4.0 * used.figures.spacing);
  for (const PressMeasurement& m : pressSweep().presses[0].settings) EXPECT_EQ(m.figures.allocations, 0u);
}

TEST(PressSweep, IsWrongWhereNothingHoldsThePart) {
  const PartExperiment e = buildPress(Family::blobs, 0, 0);
  const haptics::ContactScene bare(e.scene, 1);
  PartMeasurement m;
  measureTick(e, bare, 1, 10, nullptr, m);
  EXPECT_GT(m.depth.max, 0.5e-3);
  EXPECT_TRUE(m.solved.empty());
}

TEST(Manifold, PutsTicksOfAboutAsManyRowsTogether) {
  std::vector<RowsAndCost> ticks;
  for (int i = 0; i < 10; ++i)
    for (const int rows : {0, 1, 3, 4, 5, 6, 7, 12}) ticks.push_back({rows, 10.0 * rows + i});
  ticks.push_back({100, 1.0});
  const std::vector<ManifoldBin> bins = manifoldBins(ticks);
  ASSERT_EQ(bins.size(), 5u) << "1; 3; 4 and 5; 6 and 7; 12; and no bin for a single tick";
  EXPECT_EQ(bins[0].rows, 1.0);
  EXPECT_EQ(bins[1].rows, 3.0);
  EXPECT_EQ(bins[2].rows, 4.5);
  EXPECT_EQ(bins[2].ticks, 20u);
  EXPECT_EQ(bins[3].rows, 6.5);
  EXPECT_EQ(bins[4].p50, 125.0);
  EXPECT_EQ(bins[4].p99, 129.0);
  EXPECT_TRUE(manifoldBins({}).empty());
}

TEST(PressReport, StandsOnThePageAndInTheData) {
  const std::string text = toJson(pressSweep()), html = htmlPage(pressSweep(), text);
  expectBalanced(html);
  for (const char* part : {"Irregular parts, pressed", "Lumpy blobs, at the samples alone",
                           "rows measured or made active in the tick", "presses<br>beyond 5 µm",
                           "Lumpy blobs, pressed: penetration, largest"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  EXPECT_EQ(html.find(">unstable<"), std::string::npos);
  const nlohmann::json json = nlohmann::json::parse(text);
  const auto& setting = json.at("presses").at(0).at("settings").at(0);
  EXPECT_EQ(setting.at("id"), "tandem");
  EXPECT_GT(setting.at("force_change_n").at("p99"), 0.0);
  EXPECT_FALSE(setting.contains("error_n")) << "no exact force is known";
  EXPECT_GT(setting.at("by_solved_rows").size(), 2u);
}

}  // namespace
}  // namespace tandem::test
