// Shading where edges are meant to be felt: creases of 60 degrees, inward and outward, at three scales; what
// the force works around closed loops; shading with friction.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/haptics/hand_probe.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

constexpr double kScales[] = {1e-3, 1.0, 20.0};
constexpr double kTurn = kPi / 3.0;  // rad, between the normals of the two faces
constexpr double kSmooth = 0.5;      // rad, a crease angle below kTurn

struct Feel {
  double creaseAngle = 0.0;  // rad; 0 = flat facets
  double staticFriction = 0.0, dynamicFriction = 0.0;
};

assets::Scene sceneOf(assets::Mesh mesh, const Feel& feel) {
  SceneBuilder b;
  assets::Material& material = b.scene.materials[0];
  material.staticFriction = feel.staticFriction;
  material.dynamicFriction = feel.dynamicFriction;
  if (feel.creaseAngle > 0.0) {
    b.scene.surfaces.emplace_back();
    b.scene.surfaces[0].creaseAngle = feel.creaseAngle;
    material.surface = 0;
  }
  b.addPart(std::move(mesh));
  return b.scene;
}

/// Two faces that meet in the y axis, the free space above them; forces are the same at every scale.
class Crease {
 public:
  Crease(bool convex, double scale, const Feel& feel)
      : scale_(scale),
        hand_(sceneOf(grooveMesh(0.05 * scale, convex ? kPi - kTurn : kTurn), feel),
              springOnly(1000.0 / scale)) {}

  const haptics::TickOutput& at(const glm::dvec3& place) { return hand_.at(place * scale_); }
  void start(const glm::dvec3& place) {
    at({place.x, place.y, 0.03});
    hand_.to(place * scale_, 1e-4 * scale_);
  }
  glm::dvec3 force() const { return hand_.out.hands[0].toHand.force; }

 private:
  double scale_;
  HandProbe hand_;
};

/// Along x across the crease, 1 mm under the faces.
glm::dvec3 under(bool convex, double x) {
  const double rise = std::abs(x) / std::tan(kTurn);
  return {x, 0.001, (convex ? -rise : rise) - 0.001};
}

/// The largest change of force by shading across the crease, N.
double changeByShading(bool convex, double scale, double creaseAngle) {
  Crease shaded(convex, scale, {creaseAngle, 0.0, 0.0}), plain(convex, scale, {});
  shaded.start(under(convex, -0.02));
  plain.start(under(convex, -0.02));
  double worst = 0.0;
  for (int i = 0; i <= 400; ++i) {
    const glm::dvec3 place = under(convex, -0.02 + 1e-4 * i);
    shaded.at(place);
    plain.at(place);
    worst = std::max(worst, glm::length(shaded.force() - plain.force()));
  }
  return worst;
}

TEST(Creases, OfSixtyDegreesStaySharpAtEveryScale) {
  for (const bool convex : {false, true})
    for (const double scale : kScales) {
      EXPECT_LT(changeByShading(convex, scale, kSmooth), 1e-6) << (convex ? "convex " : "concave ") << scale;
      // Told to smooth over even that, the same edge does feel different.
      EXPECT_GT(changeByShading(convex, scale, 2.0), 0.1) << (convex ? "convex " : "concave ") << scale;
    }
}

/// What a closed loop gave to the hand.
struct Loop {
  double work = 0.0;      // J, of the force as it is
  double naive = 0.0;     // J, of the same depth along normals that are blended across the crease
  double stored = 0.0;    // J, the most that was in the spring
  double overCone = 0.0;  // largest ratio of friction to pressing force over the static coefficient, less 1
};

/// Around an ellipse that dips into both faces, `times` times; `way` +1 or -1.
Loop around(bool convex, double scale, const Feel& feel, int way, int times = 3) {
  constexpr int kSteps = 3000;
  Crease crease(convex, scale, feel);
  const auto place = [&](int i) {
    const double a = way * 2.0 * kPi * i / kSteps;
    const double low = convex ? -0.0022 : 0.0008;
    return glm::dvec3(0.0015 + 0.004 * std::cos(a), 0.001 + 0.0005 * std::sin(a), low + 0.0015 * std::sin(a));
  };
  const auto blended = [&](const glm::dvec3& at, const glm::dvec3& force) {
    const double t = std::clamp(0.5 + at.x / 0.008, 0.0, 1.0), angle = (t - 0.5) * (convex ? kTurn : -kTurn);
    return glm::length(force) * glm::dvec3(std::sin(angle), 0.0, std::cos(angle));
  };
  crease.start(place(0));
  for (int i = 1; i <= kSteps; ++i) crease.at(place(i));  // one round to settle
  Loop loop;
  glm::dvec3 before = crease.force(), naiveBefore = blended(place(0), before);
  for (int i = 1; i <= times * kSteps; ++i) {
    const glm::dvec3 step = (place(i) - place(i - 1)) * scale;
    const haptics::TickOutput& out = crease.at(place(i));
    const glm::dvec3 now = crease.force(), naive = blended(place(i), now);
    loop.work += glm::dot(0.5 * (before + now), step);
    loop.naive += glm::dot(0.5 * (naiveBefore + naive), step);
    loop.stored = std::max(loop.stored, 0.5 * glm::dot(now, now) * scale / 1000.0);
    if (out.contactCount == 1 && feel.staticFriction > 0.0) {
      const glm::dvec3 n = out.contacts[0].normal;
      const double pressing = glm::dot(now, n);
      if (pressing > 1e-3)
        loop.overCone =
            std::max(loop.overCone, glm::length(now - pressing * n) / (pressing * feel.staticFriction) - 1.0);
    }
    before = now;
    naiveBefore = naive;
  }
  return loop;
}

TEST(Creases, GiveNoEnergyAroundALoop) {
  for (const bool convex : {false, true}) {
    double naive = -1.0;
    for (const int way : {-1, 1}) {
      double unscaled = 0.0;
      for (const double scale : kScales) {
        const Loop loop = around(convex, scale, {kSmooth, 0.0, 0.0}, way);
        EXPECT_GT(loop.stored, 1e-4 * scale);
        EXPECT_LT(loop.work, 1e-3 * loop.stored) << convex << " " << way << " " << scale;
        if (scale == kScales[0]) unscaled = loop.work / scale;
        EXPECT_NEAR(loop.work / scale, unscaled, 1e-6 * loop.stored / scale) << "the same at every scale";
        naive = std::max(naive, loop.naive / loop.stored);
      }
    }
    // Depth times blended normals, the usual shading, gives energy one way round, and the account shows it.
    EXPECT_GT(naive, 0.05) << convex;
  }
}

TEST(Creases, WithFrictionTakeEnergyAndKeepToTheCone) {
  for (const bool convex : {false, true})
    for (const int way : {-1, 1})
      for (const double scale : kScales) {
        const Loop loop = around(convex, scale, {kSmooth, 0.4, 0.3}, way);
        EXPECT_LT(loop.work, -0.1 * loop.stored) << convex << " " << way << " " << scale;
        EXPECT_LT(loop.overCone, 0.005) << convex << " " << way << " " << scale;
      }
}

/// Largest ratio of tangential to normal force, over a stroke around a shaded sphere that starts, stops and
/// turns back, and the mean of that ratio while it slides on.
std::pair<double, double> ratiosOnSphere(double scale, int triangles) {
  const double radius = 0.05 * scale;
  HandProbe hand(sceneOf(tests::sphereMesh(radius, triangles), {kSmooth, 0.4, 0.3}),
                 springOnly(1000.0 / scale));
  double most = 0.0, sum = 0.0;
  int count = 0;
  for (int i = -60; i <= 3000; ++i) {
    const double angle = 0.4 * std::sin(2e-3 * std::max(i, 0));
    const glm::dvec3 out(std::sin(angle), 0.13 * std::sin(angle), std::cos(angle));
    const double height = i < 0 ? 1.0 + 1e-3 * (-i - 20) : 0.98;
    hand.at(glm::normalize(out) * radius * height);
    if (i < 0 || hand.out.contactCount == 0) continue;
    const glm::dvec3 n = hand.out.contacts[0].normal, f = hand.out.hands[0].toHand.force;
    const double pressing = glm::dot(f, n), ratio = glm::length(f - pressing * n) / pressing;
    most = std::max(most, ratio);
    if (i > 200 && i < 600) sum += ratio, ++count;
  }
  return {most, sum / count};
}

TEST(Creases, ShadedFrictionStaysWithinTheConeOfTheSmoothSurface) {
  const auto [most, sliding] = ratiosOnSphere(1.0, 100'000);
  EXPECT_LT(most, 0.4 * 1.001);
  EXPECT_NEAR(sliding, 0.3, 0.3 * 0.005);
  // Where the facets of a coarse mesh lie under the smooth surface, friction is that of the lesser depth.
  for (const double scale : kScales) {
    const auto [coarseMost, coarseSliding] = ratiosOnSphere(scale, 10'000);
    EXPECT_LT(coarseMost, 0.4 * 1.001) << scale;
    EXPECT_NEAR(coarseSliding, 0.29, 0.003) << scale;
  }
}

TEST(Creases, FrictionBetweenBumpsIsThatOfWhatStillPresses) {
  SceneBuilder b;
  b.scene.surfaces.emplace_back();
  assets::SurfaceTexture& texture = b.scene.surfaces[0].texture;
  texture.pattern = assets::SurfaceTexture::Pattern::bumps;  // 10 mm around their midst are even, and lower
  texture.wavelength = 0.05;
  texture.amplitude = 0.0006;
  b.scene.materials[0].surface = 0;
  b.scene.materials[0].staticFriction = b.scene.materials[0].dynamicFriction = 0.4;
  b.addPart(sheetMesh(0.2, 4));
  HandProbe hand(b.scene, springOnly(1000.0));
  hand.at({0.02, 0.025, 0.005});
  hand.to({0.02, 0.025, -0.001}, 1e-4);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 0.4, 1e-6) << "an even plate would press with 1 N";
  hand.to({0.03, 0.025, -0.001}, 1e-4);
  EXPECT_NEAR(hand.out.hands[0].toHand.force.z, 0.4, 1e-6);
  EXPECT_NEAR(-hand.out.hands[0].toHand.force.x, 0.4 * 0.4, 1e-3);
}

}  // namespace
}  // namespace tandem::test
