#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <vector>

#include "assets/generate/profile_god_object.h"
#include "tests/haptics/hard_cases/hard_case.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/full_size.h"

namespace tandem::test {
namespace {

/// Millions instead of tens of thousands of triangles and pushes.

/// By how much facets lie under the sphere that their corners lie on, m.
double sagitta(const assets::Mesh& mesh, double radius) {
  double deepest = radius;
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    deepest = std::min(deepest, std::abs(glm::dot(glm::normalize(glm::cross(b - a, c - a)), a)));
  }
  return radius - deepest;
}

std::vector<int> sphereSizes() {
  return atFullSize() ? std::vector<int>{1000, 10'000, 100'000, 1'000'000}
                      : std::vector<int>{1000, 10'000, 100'000};
}

/// What a stroke cost.
struct Sweeps {
  int most = 0;
  double mean = 0.0;  // of a tick
};

/// Strokes a sphere along a slanted circle `depth` under its surface and checks every force against the
/// sphere's.
Sweeps strokeSphere(const assets::Mesh& mesh, double sphere, double ball, double depth, double step,
                    int ticks, double scale, std::vector<glm::dvec3>& forces) {
  const double sag = sagitta(mesh, sphere), inside = sphere + ball - depth;
  ScaledHand hand(sceneOf(mesh), scale, ball);
  const glm::dvec3 u = glm::normalize(glm::dvec3(1.0, 0.2, 0.1));
  const glm::dvec3 v = glm::normalize(glm::cross(u, glm::dvec3(0.3, 1.0, -0.4)));
  hand.at(2.0 * (sphere + ball) * u);
  hand.to(inside * u, 2e-3);
  // Goal and facet agree where the goal's foot lies in the facet: at most its half size, seen from the goal's
  // depth.
  const double most = (sag + 4.0 * hand.skin()) * (sphere + ball) / inside;
  const double turn = std::sqrt(2.1 * (sag + 4.0 * hand.skin()) * sphere) / inside + 1e-9;
  Sweeps sweeps;
  for (int i = 0; i < ticks; ++i) {
    const double a = step * i / inside;
    const glm::dvec3 n = std::cos(a) * u + std::sin(a) * v;
    const glm::dvec3 force = hand.at(inside * n) / kStiffness;
    EXPECT_GE(glm::length(force), depth - sag - 4.0 * hand.skin()) << i;
    EXPECT_LE(glm::length(force), depth + most) << i;
    EXPECT_LE(glm::length(force / glm::length(force) - n), turn) << i;
    if (i % (ticks / 16) == 0) forces.push_back(force * kStiffness);
    const int swept = hand.probe.state.data().tool.proxy().sweeps;
    sweeps.most = std::max(sweeps.most, swept);
    sweeps.mean += static_cast<double>(swept) / ticks;
    if (testing::Test::HasFailure()) break;
  }
  return sweeps;
}

TEST(HardSphere, StrokeIsRightWithinTheFacets) {
  for (const int triangles : sphereSizes()) {
    const assets::Mesh mesh = tests::sphereMesh(0.05, triangles, tests::Topology::always);
    atEveryScale(2.0 * kStiffness * sagitta(mesh, 0.05), [&](double scale, std::vector<glm::dvec3>& forces) {
      strokeSphere(mesh, 0.05, 0.0, 0.002, 1e-4, 800, scale, forces);
    });
  }
}

TEST(HardSphere, FortyMillimetresDeepIsStillRight) {
  const assets::Mesh mesh =
      tests::sphereMesh(0.05, atFullSize() ? 1'000'000 : 100'000, tests::Topology::always);
  // At the goal, 10 mm from the centre, a facet is seen under half its size of about sqrt(2 sagitta R): each
  // of two scales may stand on its own one.
  const double sag = sagitta(mesh, 0.05), turn = std::sqrt(2.1 * sag * 0.05) / 0.010;
  atEveryScale(2.0 * kStiffness * (sag + 0.040 * turn), [&](double scale, std::vector<glm::dvec3>& forces) {
    const Sweeps sweeps = strokeSphere(mesh, 0.05, 0.0, 0.040, 2e-5, 800, scale, forces);
    // A tick draws the proxy 0.1 mm along, over a facet or two; at full size a tick takes 1.8 sweeps.
    EXPECT_LE(sweeps.most, 4);
    EXPECT_LE(sweeps.mean, 2.0);
  });
}

TEST(HardSphere, MicroMeshKeepsContactWithBallsOfEverySize) {
  const assets::Mesh mesh =
      tests::sphereMesh(0.01, atFullSize() ? 1'000'000 : 50'000, tests::Topology::always);
  for (const double ball : {0.0, 0.001, 0.003}) {
    atEveryScale(2.0 * kStiffness * sagitta(mesh, 0.01), [&](double scale, std::vector<glm::dvec3>& forces) {
      strokeSphere(mesh, 0.01, ball, 0.0015, 1e-4, 200, scale, forces);
    });
  }
}

TEST(HardSphere, ASmallBallThatIsDrawnFastOverManyFacetsIsThereInTheSameTick) {
  const assets::Mesh mesh = tests::sphereMesh(0.01, 200'000, tests::Topology::always);
  for (const double ball : {2e-5, 2e-4, 1e-3}) {
    std::vector<glm::dvec3> forces;
    const Sweeps sweeps = strokeSphere(mesh, 0.01, ball, 0.0015, 2e-3, 200, 1.0, forces);
    EXPECT_LE(sweeps.most, 12) << ball;
    EXPECT_LE(sweeps.mean, 7.0) << ball;
  }
}

/// Goals around the gear: 1 mm in, in and out of every gap, on a path that no edge is parallel to.
glm::dvec2 goalRoundGear(int i) {
  const double angle = 0.005 * i, radius = 0.0185 + 0.0012 * std::sin(17.3 * angle);
  return radius * glm::dvec2(std::cos(angle), std::sin(angle));
}

TEST(HardGear, AgreesWithAnExactPlanarGodObjectAtEveryTessellation) {
  std::vector<glm::dvec3> coarse;
  for (const int triangles : {1000, 10'000, 100'000}) {
    const assets::Mesh mesh = tests::gearMesh(triangles, tests::Topology::always);
    atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
      ScaledHand hand(sceneOf(mesh), scale);
      const glm::dvec2 start(0.03, 0.001);
      generate::ProfileGodObject exact(tests::gearProfile());
      exact.place(start);
      hand.at({start, 0.00487});
      exact.follow(start);
      std::vector<double> errors;
      for (int i = 0; i < 1300; ++i) {
        const glm::dvec2 goal = goalRoundGear(i);
        const glm::dvec3 force = hand.at({goal, 0.00487});
        const glm::dvec2 ideal = kStiffness * (exact.follow(goal) - goal);
        errors.push_back(glm::length(force - glm::dvec3(ideal, 0.0)) / std::max(0.08, glm::length(ideal)));
        forces.push_back(force);
      }
      std::sort(errors.begin(), errors.end());
      EXPECT_LE(errors[errors.size() * 99 / 100], 1e-4);
      EXPECT_LE(errors.back(), 1e-4);
      if (coarse.empty()) coarse = forces;
      double worst = 0.0;
      for (std::size_t i = 0; i < forces.size(); ++i)
        worst = std::max(worst, glm::length(forces[i] - coarse[i]));
      EXPECT_LE(worst, 1e-4) << triangles << " triangles";
    });
  }
}

TEST(HardGear, UsualTicksCostOneSweep) {
  const assets::Scene scene = sceneOf(tests::gearMesh(100'000, tests::Topology::always));
  for (const double ball : {0.0, 0.0005}) {
    ScaledHand hand(scene, 1.0, ball);
    hand.at({0.03, 0.001, 0.00487});
    int usual = 0, most = 0;
    for (int i = 0; i < 1300; ++i) {
      hand.at({goalRoundGear(i), 0.00487});
      const int sweeps = hand.probe.state.data().tool.proxy().sweeps;
      usual += sweeps <= 1 ? 1 : 0;
      most = std::max(most, sweeps);
    }
    EXPECT_GE(usual, 1300 * 85 / 100) << "ball " << ball;
    EXPECT_LE(most, 3 * 24 + 1);
  }
}

TEST(HardPushes, NeverPopThrough) {
  const std::vector<glm::dvec2> outline = tests::gearProfile();
  SceneBuilder gear, sphere;
  gear.addPart(tests::gearMesh(4000, tests::Topology::always));
  sphere.addPart(tests::sphereMesh(0.02, 2000, tests::Topology::always));
  const double inner = 0.02 - sagitta(sphere.scene.meshes[0], 0.02);
  const int pushes = atFullSize() ? 83'334 : 700;
  for (const double scale : kScales) {
    for (const double ball : {0.0, 0.0005}) {
      ScaledHand onGear(gear.scene, scale, ball), onSphere(sphere.scene, scale, ball);
      onGear.at({0.04, 0.0, 0.0});
      onSphere.at({0.04, 0.0, 0.0});
      std::uint32_t seed = 12345;
      const auto random = [&seed] {
        seed = seed * 1664525u + 1013904223u;
        return static_cast<double>(seed >> 8) / double(1 << 24) * 2.0 - 1.0;
      };
      for (int i = 0; i < pushes; ++i) {
        const glm::dvec3 goal(0.03 * random(), 0.03 * random(), 0.02 * random());
        onGear.at(goal);
        const glm::dvec3 p = onGear.proxy();
        const bool within = p.z > 0.0 && p.z < tests::kGearHeight;
        ASSERT_FALSE(within && generate::insideProfile(outline, {p.x, p.y})) << "gear, push " << i;
        onSphere.at(goal);
        ASSERT_GE(glm::length(onSphere.proxy()), inner + 0.999 * ball) << "sphere, push " << i;
      }
    }
  }
}

/// A sphere whose corners stand at random heights: spikes, saddles and narrow valleys. It is visible whole
/// from its centre.
assets::Mesh spikyStar(double radius, std::uint32_t seed) {
  assets::Mesh mesh = tests::sphereMesh(radius, 120, tests::Topology::always);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> height(0.35, 1.6);
  for (glm::dvec3& p : mesh.positions) p *= height(random);
  mesh.bounds = {};
  for (const glm::dvec3& p : mesh.positions) {
    mesh.bounds.include(p);
  }
  return mesh;
}

/// Where p lies between the centre of a star and its surface: above 1 outside.
double heightOverStar(const assets::Mesh& mesh, const glm::dvec3& p) {
  double least = 1e300;
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const double volume = glm::dot(a, glm::cross(b, c));
    const double u = glm::dot(p, glm::cross(b, c)) / volume, v = glm::dot(a, glm::cross(p, c)) / volume,
                 w = glm::dot(a, glm::cross(b, p)) / volume;
    if (u >= -1e-12 && v >= -1e-12 && w >= -1e-12) least = std::min(least, u + v + w);
  }
  return least;
}

TEST(HardPushes, ASpikyStarIsNeitherEnteredNorACauseOfUnrest) {
  const int stars = atFullSize() ? 400 : 12;
  for (const double ball : {0.0, 0.006, 0.02}) {
    for (int star = 0; star < stars; ++star) {
      const assets::Mesh mesh = spikyStar(0.02, static_cast<std::uint32_t>(star));
      ScaledHand hand(sceneOf(mesh), 1.0, ball);
      hand.at({0.08, 0.0, 0.0});
      std::mt19937 random(static_cast<std::uint32_t>(star) + 1000);
      std::normal_distribution<double> step(0.0, 0.002);
      glm::dvec3 goal(0.08, 0.0, 0.0);
      for (int i = 0; i < 200; ++i) {
        goal += glm::dvec3(step(random), step(random), step(random)) - 0.02 * goal;
        hand.at(goal);
        // The tip is drawn a skin off what it touches, up to a margin nearer than the proxy; a face that it
        // does not touch may lie within that margin.
        const auto& data = hand.probe.state.data();
        const glm::dvec3 proxy = data.tool.proxy().position, drawn = hand.proxy();
        const double margin = data.world.margin(0, proxy, ball);
        ASSERT_GE(heightOverStar(mesh, proxy), 1.0) << "ball " << ball << " star " << star << " tick " << i;
        ASSERT_LE((1.0 - heightOverStar(mesh, drawn)) * glm::length(drawn), margin)
            << "ball " << ball << " star " << star << " tick " << i;
      }
      for (int i = 0; i < 60; ++i) hand.at(goal);
      const glm::dvec3 rest = hand.proxy();
      hand.at(goal);
      EXPECT_LE(glm::length(hand.proxy() - rest), 1e-6 * 0.02) << "ball " << ball << " star " << star;
      EXPECT_LT(hand.probe.state.data().tool.proxy().sweeps, 24) << "ball " << ball << " star " << star;
    }
  }
}

/// How much a free straight step from p shortens the way to the goal at best, as a share of the step: 0 where
/// p is the nearest place there is nearby. Tries steps of 1e-5 to 1e-1 of the way, along what touches the
/// ball there.
double bestStep(const assets::Mesh& mesh, double skin, const glm::dvec3& p, const glm::dvec3& goal,
                double radius) {
  std::vector<haptics::Triangle> near;
  std::vector<glm::dvec3> normals;
  const double way = glm::length(goal - p);
  for (const auto& t : mesh.triangles) {
    const haptics::Triangle triangle{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
    const glm::dvec3 out = p - haptics::closestPointOnTriangle(p, triangle).point;
    const double distance = glm::length(out);
    if (distance < radius + 0.2 * way) near.push_back(triangle);
    if (distance < radius + 1.6 * skin) normals.push_back(out / distance);
  }
  const auto isFree = [&](const glm::dvec3& x) {
    return std::all_of(near.begin(), near.end(), [&](const haptics::Triangle& t) {
      return glm::length(x - haptics::closestPointOnTriangle(x, t).point) >= radius + 0.9 * skin;
    });
  };
  std::mt19937 random(1);
  std::normal_distribution<double> some(0.0, 0.3);
  double best = 0.0;
  for (double step = 1e-5 * way; step < 0.2 * way; step *= 10.0) {
    for (int i = 0; i < 40; ++i) {
      glm::dvec3 along = (goal - p) / way + glm::dvec3(some(random), some(random), some(random));
      for (int pass = 0; pass < 20; ++pass) {
        for (const glm::dvec3& n : normals) along -= n * std::min(0.0, glm::dot(n, along) - 1e-12);
      }
      if (!(glm::length(along) > 1e-9)) continue;
      along = glm::normalize(along);
      const double gain = (way - glm::length(goal - p - step * along)) / step;
      bool passes = gain > best;
      for (int part = 1; part <= 6 && passes; ++part) {
        const glm::dvec3 x = p + along * (step * part / 6.0);
        passes = isFree(x) && (radius > 0.0 || heightOverStar(mesh, x) >= 1.0);
      }
      if (passes) best = gain;
    }
  }
  return best;
}

// A point in a corner where a rising face ends at a ridge, and a ball that lies in the valley between two
// spikes that are far thinner than it, were held where the way on was free.
TEST(HardPushes, OnASpikyStarNoFreeStepLeadsOn) {
  const int stars = atFullSize() ? 2000 : 60;
  for (const double ball : {0.0, 0.2}) {
    for (int star = 0; star < stars; ++star) {
      const assets::Mesh mesh = spikyStar(0.02, static_cast<std::uint32_t>(star));
      ScaledHand hand(sceneOf(mesh), 1.0, ball);
      std::mt19937 random(static_cast<std::uint32_t>(star) + 5000);
      std::normal_distribution<double> some(0.0, 0.01);
      glm::dvec3 goal(0.06 + ball, 0.0, 0.0);
      hand.at(goal);
      for (int press = 0; press < 4; ++press) {
        const glm::dvec3 from = goal;
        goal = {some(random), some(random), some(random)};
        for (int i = 1; i <= 20; ++i) hand.at(from + (goal - from) * (i / 20.0));
        for (int i = 0; i < 40; ++i) hand.at(goal);
        const auto& data = hand.probe.state.data();
        const double skin = data.world.skin(0, hand.proxy());
        if (glm::length(hand.proxy() - goal) < 1e-5) continue;
        EXPECT_LT(bestStep(mesh, skin, hand.proxy(), goal, ball), 3e-3)
            << "ball " << ball << " star " << star << " press " << press << " sweeps "
            << data.tool.proxy().sweeps;
      }
    }
  }
}

/// A prism of n sides about z.
assets::Mesh needleMesh(double radius, double halfLength, int n) {
  std::vector<glm::dvec3> corners;
  const auto at = [&](int i, double z) {
    const double angle = 2.0 * std::numbers::pi * i / n;
    return glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  const double h = halfLength;
  for (int i = 0; i < n; ++i) {
    corners.insert(corners.end(), {at(i, -h), at(i + 1, -h), at(i + 1, h)});
    corners.insert(corners.end(), {at(i, -h), at(i + 1, h), at(i, h)});
    corners.insert(corners.end(), {glm::dvec3(0.0, 0.0, h), at(i, h), at(i + 1, h)});
    corners.insert(corners.end(), {glm::dvec3(0.0, 0.0, -h), at(i + 1, -h), at(i, -h)});
  }
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t i = 0; i < corners.size(); i += 3) triangles.push_back({i, i + 1, i + 2});
  return soupMesh(corners, triangles);
}

// Cutting the ball's way where the ground turns, as a point's is, takes it 300 ticks and more.
TEST(HardConvex, ABallIsRoundANeedleFarThinnerThanItInTheTickThatPushesItBehind) {
  atEveryScale(1e-6, [&](double scale, std::vector<glm::dvec3>& forces) {
    for (const double thin : {1e-6, 1e-5, 1e-4}) {
      for (const double depth : {0.003, 0.006, 0.01}) {
        ScaledHand hand(sceneOf(needleMesh(thin, 0.02, 64)), scale, 0.002);
        hand.at({-0.01, 1e-4, 0.0});
        const glm::dvec3 goal(depth, 1e-4, 0.0);
        hand.to({0.0, 1e-4, 0.0}, 5e-4);
        EXPECT_GT(glm::length(hand.force()), 1.0) << thin;
        hand.to(goal, 5e-4);
        forces.push_back(hand.at(goal));
        EXPECT_LT(glm::length(hand.proxy() - goal), 1e-8) << "thin " << thin << " depth " << depth;
      }
    }
  });
}

}  // namespace
}  // namespace tandem::test
