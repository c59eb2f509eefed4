#include <cmath>
#include <random>

#include "haptics/geometry/plane_projection.h"
#include "haptics/proxy/contact_force.h"
#include "tests/haptics/hard_cases/hard_case.h"

namespace tandem::test {
namespace {

using haptics::HalfSpace;

/// Two walls of a groove at `half` from +z, of 200 and 2000 N/m.
struct Walls {
  std::array<HalfSpace, 2> planes;
  std::array<double, 2> stiffness{200.0, 2000.0};

  explicit Walls(double half) {
    planes[0] = {{std::cos(half), 0.0, std::sin(half)}, 0.0};
    planes[1] = {{-std::cos(half), 0.0, std::sin(half)}, 0.0};
  }

  struct Active {
    std::array<glm::dvec3, 3> normals{};
    std::array<double, 3> depths{}, stiffnesses{};
    int count = 0;
  };
  Active activeAt(const glm::dvec3& goal) const {
    const haptics::Projection found = haptics::projectOntoPlanes(goal, planes, 1e-15);
    Active active;
    for (std::size_t i = 0; i < 2; ++i) {
      if (!(found.multiplier[i] > 0.0)) continue;
      const auto at = static_cast<std::size_t>(active.count++);
      active.normals[at] = planes[i].normal;
      active.depths[at] = found.multiplier[i];
      active.stiffnesses[at] = stiffness[i];
    }
    return active;
  }
  glm::dvec3 force(const glm::dvec3& goal) const {
    const Active a = activeAt(goal);
    if (a.count == 0) return glm::dvec3(0.0);
    const haptics::NormalForces f = haptics::normalForces(a.normals, a.depths, a.stiffnesses, a.count);
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < 3; ++i) sum += f.along[i] * a.normals[i];
    return sum;
  }
  /// Each spring along its own normal, as if the others were not there.
  glm::dvec3 perPlane(const glm::dvec3& goal) const {
    const Active a = activeAt(goal);
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < 3; ++i) sum += a.stiffnesses[i] * a.depths[i] * a.normals[i];
    return sum;
  }
  double potential(const glm::dvec3& goal) const {
    const Active a = activeAt(goal);
    glm::dvec3 lag(0.0);
    double squares = 0.0, weighted = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      lag += a.depths[i] * a.normals[i];
      squares += a.depths[i] * a.depths[i];
      weighted += a.stiffnesses[i] * a.depths[i] * a.depths[i];
    }
    return squares > 0.0 ? 0.5 * weighted / squares * glm::dot(lag, lag) : 0.0;
  }
};

/// Work of a force field along a closed circle in the plane y = 0, J, by the midpoint rule.
template <typename Field>
double loopWork(const Field& field, const glm::dvec3& centre, double radius) {
  constexpr int kSteps = 20'000;
  double work = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const auto at = [&](double step) {
      const double a = 2.0 * kPi * step / kSteps;
      return centre + radius * glm::dvec3(std::cos(a), 0.0, std::sin(a));
    };
    work += glm::dot(field(at(i + 0.5)), at(i + 1.0) - at(i));
  }
  return work;
}

TEST(MixedStiffness, ForceIsMinusTheGradientOfThePotential) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (const double half : {0.2, 0.5, kPi / 4.0, 1.1, 1.3}) {
    const Walls walls(half);
    for (int i = 0; i < 200; ++i) {
      const glm::dvec3 g = 0.003 * glm::dvec3(u(random), u(random), u(random) - 0.5);
      const double h = 1e-8;
      glm::dvec3 gradient;
      for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 step(0.0);
        step[axis] = h;
        gradient[axis] = (walls.potential(g + step) - walls.potential(g - step)) / (2.0 * h);
      }
      EXPECT_LE(glm::length(walls.force(g) + gradient), 2e-4) << "half angle " << half;
    }
  }
}

TEST(MixedStiffness, DoesNoWorkRoundAClosedLoopAndTheSumOfSpringsDoes) {
  for (const double half : {0.4, 0.6, kPi / 4.0, 1.0}) {
    const Walls walls(half);
    const glm::dvec3 centre(0.0003, 0.0, -0.003);
    const double radius = 0.002, scale = 2000.0 * radius * radius;  // J
    EXPECT_LE(std::abs(loopWork([&](const glm::dvec3& g) { return walls.force(g); }, centre, radius)),
              1e-6 * scale);
    if (half == kPi / 4.0) continue;  // springs at right angles do not know of each other
    EXPECT_GE(std::abs(loopWork([&](const glm::dvec3& g) { return walls.perPlane(g); }, centre, radius)),
              1e-2 * scale);
  }
}

TEST(MixedStiffness, IsContinuousWhereAContactComesOrGoes) {
  for (const double half : {0.4, kPi / 4.0, 1.0}) {
    const Walls walls(half);
    glm::dvec3 before = walls.force({-0.004, 0.0, -0.002});
    const double step = 1e-7;
    for (int i = 1; i <= 80'000; ++i) {
      const glm::dvec3 force = walls.force({-0.004 + step * i, 0.0, -0.002});
      // No spring here is stiffer than some ten times 2000 N/m.
      ASSERT_LE(glm::length(force - before), 2e4 * step) << "half angle " << half << " step " << i;
      before = force;
    }
  }
}

TEST(MixedStiffness, OneStiffnessIsThePlainSpring) {
  Walls walls(0.3);
  walls.stiffness = {700.0, 700.0};
  for (int i = 0; i <= 100; ++i) {
    const glm::dvec3 g(-0.0004 + 8e-6 * i, 0.0, -0.002);
    EXPECT_LE(glm::length(walls.force(g) + 700.0 * g), 1e-12);
  }
}

/// A groove along y whose walls are different materials: 200 N/m at -x, 2000 N/m at +x.
assets::Scene mixedGroove(double half) {
  assets::Scene scene = sceneOf(grooveMesh(0.05, half));
  scene.materials.resize(2);
  scene.materials[0].stiffness = 2000.0;
  scene.materials[1].stiffness = 200.0;
  assets::Mesh& mesh = scene.meshes[0];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t v : mesh.triangles[i]) {
      if (mesh.positions[v].x < 0.0) mesh.triangleMaterial[i] = 1;
    }
  }
  return scene;
}

TEST(MixedStiffness, GrooveOfTwoMaterialsGivesNoEnergyAwayInTheTick) {
  for (const double half : {0.5, kPi / 4.0, 1.0}) {
    atEveryScale(1e-3, [&](double scale, std::vector<glm::dvec3>& forces) {
      ScaledHand hand(mixedGroove(half), scale);
      const Walls walls(half);
      const glm::dvec3 centre(0.0, 0.001, -0.003);
      const auto at = [&](double step) {
        const double a = 2.0 * kPi * step / 2000;
        return centre + 0.002 * glm::dvec3(std::cos(a), 0.0, std::sin(a));
      };
      hand.at({0.0, 0.001, 0.02});
      hand.to(at(0.0), 2e-4);
      double work = 0.0;
      glm::dvec3 before = hand.force();
      for (int i = 1; i <= 2000; ++i) {
        const glm::dvec3 force = hand.at(at(i));
        EXPECT_LE(glm::length(force - walls.force(at(i))), 2e-3) << i;
        work += glm::dot(0.5 * (force + before), at(i) - at(i - 1.0));
        before = force;
        if (i % 100 == 0) forces.push_back(force);
      }
      EXPECT_LE(std::abs(work), 1e-5 * 2000.0 * 0.002 * 0.002);
    });
  }
}

}  // namespace
}  // namespace tandem::test
