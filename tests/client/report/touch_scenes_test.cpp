// Scenes of the report that hover over a surface, enter and leave, and rough scans, of which no exact force
// is known.

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include <glm/geometric.hpp>

#include "client/report/html.h"
#include "client/report/report_json.h"
#include "client/report/sweep.h"
#include "tests/client/report/report_checks.h"
#include "tests/support/allocation_counter.h"

namespace tandem::test {
namespace {

using namespace client::report;

/// A quick sweep of these scenes, which several tests share.
const SweepResult& touchSweep() {
  static const SweepResult result = [] {
    SweepOptions options;
    options.quick = true;
    options.only = {"hover-gear-10k", "hover-sphere-10k", "scan-10k"};
    options.allocations = &allocationCount;
    return sweep(options);
  }();
  return result;
}

const Measurement& touchSetting(const std::string& scene, const std::string& setting) {
  for (const ExperimentResult& e : touchSweep().experiments)
    for (const Measurement& m : e.settings)
      if (e.info.id == scene && m.setting == setting) return m;
  throw std::runtime_error("no setting " + setting + " of " + scene);
}

TEST(TouchScenes, HoverEnterAndLeave) {
  for (const char* id : {"hover-gear-10k", "hover-sphere-10k"}) {
    int entered = 0, left = 0, hovering = 0;
    bool inside = false;
    for (const PathPoint& p : buildExperiment(id, 2000).path) {
      const bool touches = p.exactProxy != p.device;
      entered += touches && !inside ? 1 : 0;
      left += !touches && inside ? 1 : 0;
      hovering += touches ? 0 : 1;
      inside = touches;
    }
    EXPECT_EQ(entered, 4) << id;
    EXPECT_EQ(left, 4) << id;
    EXPECT_GT(hovering, 600) << id;
    EXPECT_LT(hovering, 1400) << id;
  }
}

TEST(TouchScenes, HoveringIsExactWhereABaselineOfOnePlaneATickIsNot) {
  EXPECT_LE(touchSetting("hover-gear-10k", "tandem").error.max, 1e-6);
  EXPECT_GE(touchSetting("hover-gear-10k", "one-plane-double").error.p99, 0.5);
  EXPECT_LE(touchSetting("hover-sphere-10k", "shading").error.max, 1e-4);
  EXPECT_GE(touchSetting("hover-sphere-10k", "tandem").error.max, 1e-2);
  for (const char* id : {"hover-gear-10k", "hover-sphere-10k"})
    EXPECT_GT(touchSetting(id, "tandem").hovering.p50, 0.0);
}

TEST(TouchScenes, AScanIsFeltAsItsBodyWithinItsRoughness) {
  const Experiment scan = buildExperiment("scan-10k", 300);
  const double edge = 0.4e-3, noise = 0.05 * edge;
  for (std::size_t i = 50; i < scan.path.size(); i += 50) {
    // No part of the mesh is nearer to the hand than the body, but for noise and facets.
    double nearest = 1.0;
    for (const glm::dvec3& p : scan.scene.meshes[0].positions)
      nearest = std::min(nearest, glm::distance(p, scan.path[i].device));
    const double exact = glm::distance(scan.path[i].exactProxy, scan.path[i].device);
    EXPECT_GE(nearest, exact - 2.0 * noise) << i;
    EXPECT_LE(nearest, exact + edge) << i;
  }
  EXPECT_LE(touchSetting("scan-10k", "tandem").error.relativeP99, 0.25);
}

TEST(TouchScenes, ShadingKicksNowhereOnAScanWhereFacetsDo) {
  const Measurement &shaded = touchSetting("scan-10k", "shading"),
                    &facets = touchSetting("scan-10k", "tandem");
  EXPECT_LE(shaded.beyondDepth, 1e-9);
  EXPECT_LE(shaded.step.beyondTravel, kFeltJump);
  EXPECT_EQ(shaded.step.jumps, 0u);
  EXPECT_GT(facets.step.jumps, 10u);
  EXPECT_GT(facets.step.beyondTravel, kFeltJump);
}

/// A plane with a hand that hovers, enters by 1 mm a tick and leaves.
Experiment steppedHand() {
  Experiment e;
  for (const double z : {1e-3, 1e-3, -1e-3, -2e-3, 1e-3, 1e-3})
    e.path.push_back({{0.0, 0.0, z}, {0.0, 0.0, std::max(z, 0.0)}, 0.0});
  return e;
}

TEST(Judge, SaysByHowMuchAForceIsBeyondTravelAndDepthAndWhatHoveringCosts) {
  const Experiment e = steppedHand();
  Samples run;
  run.us = {9.0, 9.0, 5.0, 5.0, 2.0, 3.0};
  run.depth = {0.0, 0.0, 1e-3, 2e-3, 0.0, 0.0};
  for (const double force : {0.0, 0.0, 1.0, 2.5, 0.0, 0.0}) run.force.emplace_back(0.0, 0.0, force);
  Measurement m;
  judge(e, {run}, m);
  EXPECT_NEAR(m.beyondDepth, 0.5, 1e-12);
  EXPECT_NEAR(m.step.beyondTravel, 0.5, 1e-12);  // 1.5 N for 1 mm; the fall of 2.5 N came with 3 mm
  EXPECT_EQ(m.step.jumps, 1u);
  EXPECT_NEAR(m.hovering.max, 3.0, 1e-12);  // before the first contact nothing counts
  EXPECT_NEAR(m.cost.max, 9.0, 1e-12);
  run.force[3].z = 2.0;
  Measurement right;
  judge(e, {run}, right);
  EXPECT_NEAR(right.beyondDepth, 0.0, 1e-12);
  EXPECT_EQ(right.step.jumps, 0u);
}

TEST(TouchScenes, ArePartOfThePageAndItsData) {
  const std::string json = toJson(touchSweep()), html = htmlPage(touchSweep(), json);
  expectBalanced(html);
  for (const char* text : {"Hovering over a gear", "10 k, hovering", "change of force a tick beyond 1 N/mm",
                           "force shading: force beyond 1 N/mm x depth"})
    EXPECT_NE(html.find(text), std::string::npos) << text;
  for (const char* key : {"\"beyond_travel\"", "\"jumps\"", "\"beyond_depth_n\"", "\"hovering_us\""})
    EXPECT_NE(json.find(key), std::string::npos) << key;
}

}  // namespace
}  // namespace tandem::test
