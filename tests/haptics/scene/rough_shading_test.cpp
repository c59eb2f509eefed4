// Shading of meshes whose vertices are noise, as scans are: it adds no force and no jump to what the facets
// give, at any depth and scale.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "assets/mesh/mesh_analysis.h"
#include "haptics/scene/contact_world.h"
#include "haptics/scene/corner_normals.h"
#include "tests/haptics/hand_probe.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

constexpr double kRoughCrease = 1.2;  // rad, above what the noise makes
constexpr double kUnfelt = 0.05;      // N, a change of the force that may come with any travel
constexpr double kStiffness = 1e3;    // N/m at scale 1

enum class Shape { sphere, plane, terrain, torus };
constexpr Shape kShapes[] = {Shape::sphere, Shape::plane, Shape::terrain, Shape::torus};

/// A closed grid of a torus, or an open one of a sheet, out of a map of the unit square.
template <typename Map>
assets::TriangleSoup gridOf(int n, bool wraps, const Map& map) {
  assets::TriangleSoup soup;
  const int rows = wraps ? n : n + 1;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < rows; ++i) soup.positions.push_back(map(double(i) / n, double(j) / n));
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j % rows * rows + i % rows); };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  soup.triangleMaterial.assign(soup.triangles.size(), 0);
  return soup;
}

assets::TriangleSoup smoothShape(Shape shape) {
  if (shape == Shape::sphere) {
    const assets::Mesh sphere = tests::sphereMesh(0.05, 8'000);
    assets::TriangleSoup soup;
    soup.positions = sphere.positions;
    soup.triangles = sphere.triangles;
    soup.triangleMaterial = sphere.triangleMaterial;
    return soup;
  }
  if (shape == Shape::torus)
    return gridOf(60, true, [](double u, double v) {
      const double a = 2.0 * kPi * u, b = 2.0 * kPi * v, r = 0.04 + 0.02 * std::cos(b);
      return glm::dvec3(r * std::cos(a), r * std::sin(a), 0.02 * std::sin(b));
    });
  const double height = shape == Shape::terrain ? 0.004 : 0.0;
  return gridOf(50, false, [height](double u, double v) {
    return glm::dvec3(0.1 * u - 0.05, 0.1 * v - 0.05, height * std::sin(9.0 * u) * std::cos(7.0 * v));
  });
}

/// A mesh whose vertices are off by `noise` mean edges, and that edge, m.
struct RoughMesh {
  assets::Mesh mesh;
  double edge = 0.0;

  RoughMesh(Shape shape, double noise, double scale, unsigned seed) {
    assets::TriangleSoup soup = smoothShape(shape);
    for (glm::dvec3& p : soup.positions) p *= scale;
    for (const auto& t : soup.triangles) edge += glm::distance(soup.positions[t[0]], soup.positions[t[1]]);
    edge /= static_cast<double>(soup.triangles.size());
    std::mt19937 random(seed);
    std::normal_distribution<double> off(0.0, noise * edge);
    for (glm::dvec3& p : soup.positions) {
      for (int k = 0; k < 3; ++k) p[k] += off(random);
    }
    mesh = assets::analyseMesh(std::move(soup), 0.5).mesh;
  }
};

assets::Scene roughSceneOf(const assets::Mesh& mesh, double crease) {
  SceneBuilder b;
  if (crease > 0.0) {
    b.scene.surfaces.emplace_back();
    b.scene.surfaces[0].creaseAngle = crease;
    b.scene.materials[0].surface = 0;
  }
  b.addPart(mesh);
  return b.scene;
}

/// A stroke over the shape without noise, some `depth` under it, with turns that a hand might make.
class Stroke {
 public:
  Stroke(Shape shape, double scale, double depth, double ball, unsigned seed)
      : shape_(shape), scale_(scale), depth_(depth), ball_(ball), random_(seed), way_(6.28 * turn_(random_)) {
    u_ = 0.3 + 0.4 * turn_(random_);
    v_ = 0.3 + 0.4 * turn_(random_);
  }

  /// The next place of the device, m. The first ones come from outside.
  glm::dvec3 next() {
    way_ += 0.2 * (turn_(random_) - 0.5);
    const double step = 1.2e-3;
    u_ += step * std::cos(way_);
    v_ += step * std::sin(way_);
    if (shape_ != Shape::torus && (u_ < 0.25 || u_ > 0.75 || v_ < 0.25 || v_ > 0.75)) way_ += 0.3;
    const double pressed = 0.75 + 0.25 * std::sin(0.013 * ticks_);
    const double in = std::min(1.0, ++ticks_ / 50.0 - 2.0) * depth_ * pressed;
    return under(in - ball_);
  }

 private:
  glm::dvec3 under(double in) const {
    if (shape_ == Shape::sphere) {
      const double a = 6.28 * u_, b = 1.57 + 1.5 * (v_ - 0.5);
      const glm::dvec3 n(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b));
      return n * (0.05 * scale_ - in);
    }
    if (shape_ == Shape::torus) {
      const double a = 2.0 * kPi * u_, b = 2.0 * kPi * v_, r = 0.02 * scale_ - in;
      return {(0.04 * scale_ + r * std::cos(b)) * std::cos(a),
              (0.04 * scale_ + r * std::cos(b)) * std::sin(a), r * std::sin(b)};
    }
    const double height = shape_ == Shape::terrain ? 0.004 : 0.0;
    return glm::dvec3(0.1 * u_ - 0.05, 0.1 * v_ - 0.05, height * std::sin(9.0 * u_) * std::cos(7.0 * v_)) *
               scale_ -
           glm::dvec3(0.0, 0.0, in);
  }

  Shape shape_;
  double scale_, depth_, ball_;
  std::mt19937 random_;
  std::uniform_real_distribution<double> turn_{0.0, 1.0};
  double way_, u_ = 0.5, v_ = 0.5;
  int ticks_ = 0;
};

/// What shading added over a stroke.
struct Added {
  double force = 0.0;             // N, the most by which it was larger than the facets'
  double jump = 0.0;              // N, the most by which it changed more than the larger of spring and facets
  int jumps = 0, facetJumps = 0;  // ticks in which it, or the facets, changed by more than the spring
  double strongest = 0.0;         // N
};

Added shadingOver(Shape shape, double noise, double depthInEdges, double scale, double ball, unsigned seed,
                  int ticks = 1500) {
  const RoughMesh rough(shape, noise, scale, seed);
  const double stiffness = kStiffness / scale;
  HandProbe shaded(roughSceneOf(rough.mesh, kRoughCrease), springOnly(stiffness));
  HandProbe facets(roughSceneOf(rough.mesh, 0.0), springOnly(stiffness));
  shaded.parameters.toolRadius = facets.parameters.toolRadius = ball * rough.edge;
  Stroke stroke(shape, scale, depthInEdges * rough.edge, ball * rough.edge, seed);
  Added added;
  glm::dvec3 at(0.0), feltBefore(0.0), plainBefore(0.0);
  for (int i = 0; i < ticks; ++i) {
    const glm::dvec3 place = stroke.next();
    const glm::dvec3 felt = shaded.at(place).hands[0].toHand.force;
    const glm::dvec3 plain = facets.at(place).hands[0].toHand.force;
    added.force = std::max(added.force, glm::length(felt) - glm::length(plain));
    added.strongest = std::max(added.strongest, glm::length(plain));
    if (i > 0) {
      const double spring = stiffness * glm::distance(place, at);
      const double change = glm::distance(felt, feltBefore), own = glm::distance(plain, plainBefore);
      added.jump = std::max(added.jump, change - std::max(spring, own));
      added.jumps += change > spring + kUnfelt ? 1 : 0;
      added.facetJumps += own > spring + kUnfelt ? 1 : 0;
    }
    at = place;
    feltBefore = felt;
    plainBefore = plain;
  }
  return added;
}

std::string nameOf(Shape shape, double noise, double depth) {
  return "shape " + std::to_string(static_cast<int>(shape)) + " noise " + std::to_string(noise) + " depth " +
         std::to_string(depth);
}

TEST(RoughShading, AddsNeitherForceNorJumps) {
  int jumps = 0, facetJumps = 0;
  for (const Shape shape : kShapes)
    for (const double noise : {0.01, 0.05, 0.1})
      for (const double depth : {0.2, 1.0, 4.0}) {
        const Added added = shadingOver(shape, noise, depth, 1.0, 0.0, 5);
        EXPECT_GT(added.strongest, 0.05);
        EXPECT_LE(added.force, 1e-9) << nameOf(shape, noise, depth);
        EXPECT_LE(added.jump, kUnfelt) << nameOf(shape, noise, depth);
        jumps += added.jumps;
        facetJumps += added.facetJumps;
      }
  RecordProperty("jumps", jumps);
  RecordProperty("facet_jumps", facetJumps);
  EXPECT_LT(jumps, facetJumps / 4) << "of the facets' own jumps, shading takes most";
}

/// Between smooth and rough the patches are flatter than their normals say, and steps between them are felt.
TEST(RoughShading, AddsNoJumpsWhereVerticesAreAlmostOfASmoothSurface) {
  for (const Shape shape : {Shape::sphere, Shape::terrain, Shape::torus})
    for (const double noise : {0.002, 0.004, 0.006})
      for (const double depth : {0.5, 1.35})
        for (unsigned seed = 1; seed <= 4; ++seed) {
          const Added added = shadingOver(shape, noise, depth, 1.0, 0.0, seed, 1000);
          EXPECT_GT(added.strongest, 0.05);
          EXPECT_LE(added.jump, kUnfelt) << nameOf(shape, noise, depth) << " seed " << seed;
        }
}

/// The same for shading that no bound holds: the gradient of the depth under the patches alone.
Added unboundedOver(Shape shape, double noise, double depthInEdges, unsigned seed) {
  const RoughMesh rough(shape, noise, 1.0, seed);
  const double crease[] = {kRoughCrease};
  const haptics::ShadedMesh shaded = haptics::shadeMesh(rough.mesh, crease);
  HandProbe facets(roughSceneOf(rough.mesh, 0.0), springOnly(kStiffness));
  const haptics::ContactWorld world(facets.contact);
  Stroke stroke(shape, 1.0, depthInEdges * rough.edge, 0.0, seed);
  Added added;
  glm::dvec3 at(0.0), feltBefore(0.0), plainBefore(0.0);
  for (int i = 0; i < 1500; ++i) {
    const glm::dvec3 place = stroke.next();
    const haptics::TickOutput& out = facets.at(place);
    const glm::dvec3 plain = out.hands[0].toHand.force;
    glm::dvec3 felt = plain;
    haptics::SurfacePoint touched;
    haptics::PatchPoint patch;
    if (out.contactCount > 0 && world.nearest(0, out.contacts[0].point, rough.edge, touched) &&
        haptics::projectOntoPatch(rough.mesh, &shaded, touched.triangle, out.contacts[0].point, place, 1.0,
                                  patch))
      felt = -kStiffness * std::max(0.0, patch.depth) * patch.depthGradient;
    const double spring = kStiffness * glm::distance(place, at);
    const double own = glm::distance(plain, plainBefore);
    added.force = std::max(added.force, glm::length(felt) - glm::length(plain));
    if (i > 0) added.jump = std::max(added.jump, glm::distance(felt, feltBefore) - std::max(spring, own));
    at = place;
    feltBefore = felt;
    plainBefore = plain;
  }
  return added;
}

TEST(RoughShading, WithoutItsBoundsKicks) {
  for (const Shape shape : {Shape::sphere, Shape::terrain}) {
    const Added added = unboundedOver(shape, 0.05, 4.0, 5);
    EXPECT_GT(added.force, 0.5) << static_cast<int>(shape);
    EXPECT_GT(added.jump, 0.5) << static_cast<int>(shape);
  }
}

TEST(RoughShading, HoldsForBalls) {
  for (const Shape shape : {Shape::sphere, Shape::terrain})
    for (const double ball : {0.7, 3.0}) {
      const Added added = shadingOver(shape, 0.05, 1.0, 1.0, ball, 6);
      EXPECT_GT(added.strongest, 0.05);
      EXPECT_LE(added.force, 1e-9) << ball;
      EXPECT_LE(added.jump, kUnfelt) << ball;
    }
}

TEST(RoughShading, HoldsAtEveryScaleAndForEverySeed) {
  for (const double scale : {1e-3, 1.0, 20.0})
    for (unsigned seed = 1; seed <= 4; ++seed) {
      const Added added = shadingOver(Shape::terrain, 0.05, 2.0, scale, 0.0, seed, 800);
      EXPECT_LE(added.force, 1e-9) << scale << " " << seed;
      EXPECT_LE(added.jump, kUnfelt) << scale << " " << seed;
    }
}

}  // namespace
}  // namespace tandem::test
