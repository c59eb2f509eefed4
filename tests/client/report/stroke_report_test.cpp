// Strokes of a point through a model, as the report counts them.

#include <gtest/gtest.h>

#include <memory>

#include <nlohmann/json.hpp>

#include "client/report/html.h"
#include "client/report/report_json.h"
#include "client/report/sweep.h"
#include "tests/client/report/report_checks.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using namespace client::report;

/// A turned sheet of strips side by side whose rows do not match, as a file of single precision states it:
/// its seams are cracks of some 10 nm.
std::shared_ptr<const assets::Scene> crackedSheet() {
  constexpr int kStrips = 24;
  const glm::dquat turned = fromRotationVector({0.4, 0.7, 0.2});
  assets::Mesh mesh;
  const auto corner = [&](double x, double y) {
    const glm::dvec3 p = turned * glm::dvec3(x - 0.5, y - 0.5, 0.0) + glm::dvec3(0.3, 0.2, 0.1);
    mesh.positions.emplace_back(glm::vec3(p));
    mesh.bounds.include(mesh.positions.back());
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
  };
  for (int strip = 0; strip < kStrips; ++strip) {
    const double left = 1.0 * strip / kStrips, right = 1.0 * (strip + 1) / kStrips;
    const int rows = strip % 2 == 0 ? 17 : 23;
    for (int row = 0; row < rows; ++row) {
      const double low = 1.0 * row / rows, high = 1.0 * (row + 1) / rows;
      const std::uint32_t a = corner(left, low), b = corner(right, low), c = corner(right, high),
                          d = corner(left, high);
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  mesh.triangleMaterial.assign(mesh.triangles.size(), 0);
  SceneBuilder builder;
  builder.addPart(std::move(mesh));
  builder.scene.bounds = builder.scene.meshes[0].bounds;
  return std::make_shared<const assets::Scene>(std::move(builder.scene));
}

const SweepResult& strokeSweep() {
  static const SweepResult result = [] {
    SweepOptions options;
    options.quick = true;
    options.only = {"plane"};
    options.models = {{"<sheet>.glb", crackedSheet()}};
    options.strokes = 60;
    return sweep(options);
  }();
  return result;
}

TEST(StrokeReport, APointGoesWhereNoBallDoesOnlyWithoutItsLeastRadius) {
  const StrokeResult& e = strokeSweep().strokes.at(0);
  ASSERT_EQ(e.settings.size(), 2u);
  EXPECT_EQ(e.strokes, 60);
  EXPECT_GT(e.ticks, 600u);
  EXPECT_EQ(e.settings[0].fallen, 0);
  EXPECT_GT(e.settings[1].fallen, 0);
  for (const StrokeMeasurement& m : e.settings) EXPECT_GT(m.cost.p99, 0.0);
}

TEST(StrokeReport, StandsOnThePageAndInTheData) {
  const std::string text = toJson(strokeSweep()), html = htmlPage(strokeSweep(), text);
  expectBalanced(html);
  for (const char* part :
       {"Strokes through models", "&lt;sheet&gt;.glb", "0 of 60", "no least radius (control)"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  const nlohmann::json json = nlohmann::json::parse(text);
  const auto& settings = json.at("strokes").at(0).at("settings");
  EXPECT_EQ(settings.at(0).at("fallen"), 0);
  EXPECT_EQ(settings.at(1).at("id"), "bare");
  bool judged = false;
  for (const Bound& b : boundsOf(strokeSweep())) judged = judged || (b.name.find("<sheet>") == 0 && b.met());
  EXPECT_TRUE(judged);
}

}  // namespace
}  // namespace tandem::test
