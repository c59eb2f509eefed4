#include "haptics/scene/corner_normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/haptics/hand_probe.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

constexpr double kCrease = 0.5;  // rad

/// One static part whose only material shades below `crease`; 0 = without a surface.
assets::Scene shadedScene(assets::Mesh mesh, double crease = kCrease) {
  SceneBuilder b;
  if (crease > 0.0) {
    b.scene.surfaces.emplace_back();
    b.scene.surfaces[0].creaseAngle = crease;
    b.scene.materials[0].surface = 0;
  }
  b.addPart(std::move(mesh));
  return b.scene;
}

/// Errors of the force on a sphere at `depth`, as shares of k * depth, over a stroke of a great circle and a
/// spiral.
std::vector<double> sphereErrors(double radius, int triangles, double depth, double crease,
                                 double tool = 0.0) {
  HandProbe hand(shadedScene(tests::sphereMesh(radius, triangles), crease), springOnly(1000.0));
  hand.parameters.toolRadius = tool;
  std::vector<double> errors;
  for (int i = 0; i < 3000; ++i) {
    const double angle = 2e-3 * i, tilt = 0.9 + 0.2 * std::sin(0.37 * angle);
    const glm::dvec3 n(std::sin(tilt) * std::cos(angle), std::sin(tilt) * std::sin(angle), std::cos(tilt));
    if (i == 0) {
      hand.at(n * (radius + tool) * 1.01);
      hand.to(n * (radius + tool - depth), 0.01 * radius);
    }
    hand.at(n * (radius + tool - depth));
    errors.push_back(glm::length(hand.out.hands[0].toHand.force - 1000.0 * depth * n) / (1000.0 * depth));
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

double p99(const std::vector<double>& sorted) { return sorted[sorted.size() * 99 / 100]; }

TEST(ForceShading, MakesASphereOfFacetsASphere) {
  const double smooth = p99(sphereErrors(0.05, 100'000, 0.002, kCrease));
  const double flat = p99(sphereErrors(0.05, 100'000, 0.002, 0.0));
  RecordProperty("p99_percent", std::to_string(100.0 * smooth));
  EXPECT_LT(smooth, 0.001);
  EXPECT_GT(flat, 0.005) << "without shading the facets' own directions are off by most of a per cent";
}

TEST(ForceShading, HoldsForCoarseMeshesAndBalls) {
  EXPECT_LT(p99(sphereErrors(0.05, 10'000, 0.002, kCrease)), 0.01);
  EXPECT_LT(p99(sphereErrors(0.05, 100'000, 0.002, kCrease, 0.001)), 0.001);
  EXPECT_LT(p99(sphereErrors(0.05, 100'000, 0.04, kCrease)), 0.001) << "40 mm deep in a radius of 50";
}

TEST(ForceShading, DoesNotDependOnTheScale) {
  const double here = p99(sphereErrors(0.05, 10'000, 0.002, kCrease));
  for (const double scale : {1e-3, 20.0})
    EXPECT_NEAR(p99(sphereErrors(0.05 * scale, 10'000, 0.002 * scale, kCrease)), here, 0.01 * here) << scale;
}

TEST(ForceShading, KeepsASixtyDegreeCreaseSharp) {
  // A prism whose faces meet at 60 degrees: on each face the force is along that face's own normal, up to the
  // edge.
  HandProbe hand(shadedScene(grooveMesh(0.05, 60.0 * kPi / 180.0)), springOnly(1000.0));
  HandProbe plain(shadedScene(grooveMesh(0.05, 60.0 * kPi / 180.0), 0.0), springOnly(1000.0));
  for (HandProbe* each : {&hand, &plain}) each->at({-0.02, 0.001, 0.03});
  double worst = 0.0, strongest = 0.0;
  for (int i = 0; i <= 400; ++i) {
    const glm::dvec3 g(-0.02 + 1e-4 * i, 0.001, 0.3 * std::abs(-0.02 + 1e-4 * i) - 0.001);
    worst =
        std::max(worst, glm::length(hand.at(g).hands[0].toHand.force - plain.at(g).hands[0].toHand.force));
    strongest = std::max(strongest, glm::length(plain.out.hands[0].toHand.force));
  }
  EXPECT_GT(strongest, 1.0);
  EXPECT_LT(worst, 1e-6);
  // Told to smooth over even that, the same groove does feel different.
  HandProbe smoothed(shadedScene(grooveMesh(0.05, 60.0 * kPi / 180.0), 2.0), springOnly(1000.0));
  smoothed.at({-0.02, 0.001, 0.03});
  double change = 0.0;
  plain.to({-0.02, 0.001, 0.03}, 1e-3);
  for (int i = 0; i <= 400; ++i) {
    const glm::dvec3 g(-0.02 + 1e-4 * i, 0.001, 0.3 * std::abs(-0.02 + 1e-4 * i) - 0.001);
    change = std::max(change,
                      glm::length(smoothed.at(g).hands[0].toHand.force - plain.at(g).hands[0].toHand.force));
  }
  EXPECT_GT(change, 0.1);
}

/// Work of the force on the hand around a circle that dips in and out of a facetted sphere, J; and the most
/// energy that was ever stored on the way.
std::pair<double, double> loopWork(int triangles, double crease) {
  HandProbe hand(shadedScene(tests::sphereMesh(0.05, triangles), crease), springOnly(1000.0));
  const auto place = [](int i, int n) {
    const double a = 2.0 * kPi * i / n;
    const glm::dvec3 middle(0.0, 0.0, 0.0495);
    return middle + glm::dvec3(0.004 * std::cos(a), 0.003 * std::sin(a), 0.0015 * std::sin(2.0 * a));
  };
  constexpr int kSteps = 20'000;
  hand.at({0.004, 0.0, 0.052});
  hand.to(place(0, kSteps), 1e-4);
  double work = 0.0, stored = 0.0;
  glm::dvec3 before = hand.out.hands[0].toHand.force;
  for (int i = 1; i <= kSteps; ++i) {
    const glm::dvec3 step = place(i, kSteps) - place(i - 1, kSteps);
    const glm::dvec3 now = hand.at(place(i, kSteps)).hands[0].toHand.force;
    work += glm::dot(0.5 * (before + now), step);
    stored = std::max(stored, std::abs(work));
    before = now;
  }
  return {work, stored};
}

TEST(ForceShading, GainsNoEnergyRoundALoop) {
  for (const int triangles : {1'000, 10'000, 100'000}) {
    const auto [work, stored] = loopWork(triangles, kCrease);
    EXPECT_GT(stored, 1e-4);
    EXPECT_LT(std::abs(work), 1e-4 * stored) << triangles;
  }
}

TEST(ForceShading, NormalsOfASphereAreExact) {
  const assets::Mesh mesh = tests::sphereMesh(0.05, 2'000);
  const double crease[] = {kCrease};
  const haptics::ShadedMesh shaded = haptics::shadeMesh(mesh, crease);
  double worst = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const glm::dvec3 exact = glm::normalize(mesh.positions[mesh.triangles[t][c]]);
      worst = std::max(worst, glm::length(glm::dvec3(shaded.normals[t][c]) - exact));
    }
  EXPECT_LT(worst, 3e-7);
}

TEST(ForceShading, RefusesToProjectBeyondTheCentreOfCurvature) {
  const assets::Mesh mesh = tests::sphereMesh(0.05, 2'000);
  const double crease[] = {kCrease};
  const haptics::ShadedMesh shaded = haptics::shadeMesh(mesh, crease);
  const auto& c = mesh.triangles[100];
  const glm::dvec3 middle = (mesh.positions[c[0]] + mesh.positions[c[1]] + mesh.positions[c[2]]) / 3.0;
  haptics::PatchPoint found;
  EXPECT_TRUE(haptics::projectOntoPatch(mesh, &shaded, 100, middle, 0.5 * middle, 1.0, found));
  EXPECT_NEAR(found.depth, 0.025, 1e-4);
  EXPECT_FALSE(haptics::projectOntoPatch(mesh, &shaded, 100, middle, -0.1 * middle, 1.0, found));
}

}  // namespace
}  // namespace tandem::test
