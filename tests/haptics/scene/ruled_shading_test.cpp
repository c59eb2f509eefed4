// Shading where the surface curves in one direction only, cones and cylinders in irregular triangles, against
// the exact shape; and shading by the normals of a file.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "haptics/scene/corner_normals.h"
#include "tests/haptics/hand_probe.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/ruled_meshes.h"

namespace tandem::test {
namespace {

constexpr double kRuledCrease = 0.9;  // rad

assets::Scene ruledSceneOf(const assets::Mesh& mesh, double crease) {
  SceneBuilder b;
  if (crease > 0.0) {
    b.scene.surfaces.emplace_back();
    b.scene.surfaces[0].creaseAngle = crease;
    b.scene.materials[0].surface = 0;
  }
  b.addPart(mesh);
  return b.scene;
}

RuledShape scaled(const RuledShape& shape, double scale) {
  return {shape.radius * scale, shape.topRadius * scale, shape.height * scale};
}

/// Errors of the force, as shares of stiffness times depth, over a winding stroke between the shares `from`
/// and `to` of the height.
std::vector<double> errorsOn(const RuledShape& shape, const assets::Mesh& mesh, double crease, double depth,
                             double from, double to, double ball = 0.0) {
  HandProbe hand(ruledSceneOf(mesh, crease), springOnly(1000.0));
  hand.parameters.toolRadius = ball;
  std::vector<double> errors;
  for (int i = 0; i < 1500; ++i) {
    const double angle = 0.008 * i, share = 0.5 * (from + to) + 0.5 * (to - from) * std::sin(0.006 * i);
    const glm::dvec3 n = shape.normal(angle), place = shape.at(angle, share) - (depth - ball) * n;
    if (i == 0) {
      hand.at(shape.at(angle, share) + (ball + 0.1 * shape.radius) * n);
      hand.to(place, 0.01 * shape.radius);
    }
    hand.at(place);
    errors.push_back(glm::length(hand.out.hands[0].toHand.force - 1000.0 * depth * n) / (1000.0 * depth));
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

double worstOfHundred(const std::vector<double>& sorted) { return sorted[sorted.size() * 99 / 100]; }

TEST(RuledShading, IsThatOfTheExactConeOrCylinder) {
  double worst = 0.0;
  for (const double topRadius : {0.03, 0.022, 0.015})
    for (const bool normals : {false, true})
      for (unsigned seed = 1; seed <= 2; ++seed)
        for (const double scale : {1e-3, 1.0, 20.0}) {
          const RuledShape shape = scaled({0.03, topRadius, 0.06}, scale);
          const assets::Mesh mesh = ruledMesh(shape, 48, 15, seed == 1 ? 0.0 : 0.2, seed, normals);
          const double error =
              worstOfHundred(errorsOn(shape, mesh, normals ? 0.0 : kRuledCrease, 0.002 * scale, 0.15, 0.85));
          EXPECT_LT(error, 0.001) << topRadius << (normals ? " normals " : " crease ") << seed << " "
                                  << scale;
          worst = std::max(worst, error);
        }
  RecordProperty("p99_percent", std::to_string(100.0 * worst));
  const RuledShape shape;
  EXPECT_GT(worstOfHundred(errorsOn(shape, ruledMesh(shape, 48, 15, 0.0, 1, false), 0.0, 0.002, 0.15, 0.85)),
            0.03)
      << "the facets themselves are off by per cents";
}

TEST(RuledShading, HoldsFromShallowToDeepAndForBalls) {
  const RuledShape shape{0.03, 0.022, 0.06};
  const assets::Mesh mesh = ruledMesh(shape, 48, 15, 0.0, 1, true);
  for (const double depth : {0.0005, 0.005, 0.012})
    EXPECT_LT(worstOfHundred(errorsOn(shape, mesh, 0.0, depth, 0.15, 0.85)), 0.001) << depth;
  // A ball of three times the depth: heights of the patch count three times as much.
  EXPECT_LT(worstOfHundred(errorsOn(shape, mesh, 0.0, 0.001, 0.15, 0.85, 0.003)), 0.005);
}

TEST(RuledShading, RulesAFanFromItsApex) {
  // No row between base and tip: each triangle is as long as the cone.
  const RuledShape shape{0.03, 0.0, 0.06};
  for (const int around : {24, 48, 200, 700})
    for (const bool normals : {false, true}) {
      // Of slivers the rounding of the vertices is felt, unless the file has their normals.
      if (around == 700 && !normals) continue;
      const assets::Mesh mesh = ruledMesh(shape, around, 1, 0.0, 1, normals);
      EXPECT_LT(worstOfHundred(errorsOn(shape, mesh, normals ? 0.0 : kRuledCrease, 0.002, 0.1, 0.7)), 0.001)
          << around << normals;
    }
}

TEST(RuledShading, TakesNoOtherCornerForAnApex) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const assets::Mesh mesh = ruledMesh({0.03, 0.01, 0.06}, 36, 18, 0.3, seed, false);
    const double crease[] = {kRuledCrease};
    for (const haptics::CornerNormals& normals : haptics::shadeMesh(mesh, crease).normals)
      EXPECT_EQ(std::count_if(normals.begin(), normals.end(), haptics::isApex), 0) << seed;
  }
}

/// A sphere with the normals of its vertices in place of a crease angle.
assets::Mesh sphereWithNormals(double radius, int triangles) {
  assets::Mesh mesh = tests::sphereMesh(radius, triangles);
  for (const auto& t : mesh.triangles) {
    auto& normals = mesh.triangleNormal.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) normals[c] = glm::vec3(glm::normalize(mesh.positions[t[c]]));
  }
  return mesh;
}

double errorOnSphere(const assets::Mesh& mesh, double crease, double radius, double depth) {
  HandProbe hand(ruledSceneOf(mesh, crease), springOnly(1000.0));
  std::vector<double> errors;
  for (int i = 0; i < 2000; ++i) {
    const double angle = 2e-3 * i, tilt = 0.9 + 0.2 * std::sin(0.37 * angle);
    const glm::dvec3 n(std::sin(tilt) * std::cos(angle), std::sin(tilt) * std::sin(angle), std::cos(tilt));
    if (i == 0) {
      hand.at(n * radius * 1.01);
      hand.to(n * (radius - depth), 0.01 * radius);
    }
    hand.at(n * (radius - depth));
    errors.push_back(glm::length(hand.out.hands[0].toHand.force - 1000.0 * depth * n) / (1000.0 * depth));
  }
  std::sort(errors.begin(), errors.end());
  return worstOfHundred(errors);
}

TEST(NormalShading, MakesASphereOfFacetsASphereWithoutBeingAsked) {
  for (const double scale : {1e-3, 1.0, 20.0}) {
    const double error =
        errorOnSphere(sphereWithNormals(0.05 * scale, 100'000), 0.0, 0.05 * scale, 0.002 * scale);
    RecordProperty("p99_percent", std::to_string(100.0 * error));
    EXPECT_LT(error, 1e-4) << scale;
  }
  assets::Mesh without = tests::sphereMesh(0.05, 100'000);
  EXPECT_GT(errorOnSphere(without, 0.0, 0.05, 0.002), 0.005) << "facets are off by most of a per cent";
}

TEST(NormalShading, LeavesFacesAndCreasesAsTheyAre) {
  // The cap of a cylinder is flat up to its rim, beside a side that is not.
  const RuledShape shape{0.03, 0.03, 0.06};
  const assets::Mesh mesh = ruledMesh(shape, 48, 4, 0.0, 1, true);
  assets::Mesh flat = mesh;
  flat.triangleNormal.clear();
  HandProbe hand(ruledSceneOf(mesh, 0.0), springOnly(1000.0)),
      plain(ruledSceneOf(flat, 0.0), springOnly(1000.0));
  double worst = 0.0, strongest = 0.0;
  for (HandProbe* each : {&hand, &plain}) {
    each->at({0.0, 0.0, 0.061});
    each->to({0.0, 0.0, 0.058}, 1e-3);
  }
  for (int i = 0; i <= 270; ++i) {
    const glm::dvec3 place(1e-4 * i, 0.0, 0.058);
    const glm::dvec3 felt = hand.at(place).hands[0].toHand.force, own = plain.at(place).hands[0].toHand.force;
    worst = std::max(worst, glm::length(felt - own));
    strongest = std::max(strongest, glm::length(own));
  }
  EXPECT_GT(strongest, 1.9);
  EXPECT_LT(worst, 1e-6);
}

}  // namespace
}  // namespace tandem::test
