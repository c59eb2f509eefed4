// A pin of 20 mm in a bore 10 um wider, both of 48 facets, whose file states the cylinders.

#include <algorithm>
#include <numbers>

#include "assets/gltf/load_gltf.h"
#include "tests/haptics/contact/moving_rig.h"
#include "tests/support/exact_fit_file.h"

namespace tandem::test {
namespace {

constexpr double kFree = 0.05;  // N and N·m: what the mass of the pin and the coupling's damping ask for

assets::Scene exactFitScene(const ExactFit& fit) {
  assets::LoadOptions options;
  options.movable = {"pin"};
  Result<assets::Scene> scene = assets::loadGltfFromMemory("fit.glb", exactFitFile(fit).glb(), options);
  EXPECT_TRUE(scene.ok());
  return std::move(scene).value();
}

/// The pin in its bore, held by a hand. Measures by formula, from the pose alone.
class ExactFitRig {
 public:
  explicit ExactFitRig(const ExactFit& given) : fit(given), rig(exactFitScene(given), glm::dvec3(0.0), 2.0) {
    rig.each = [this] { note(); };
    rig.takeHold(0, turned(0.0));
    const double half = std::numbers::pi / fit.segments;
    rig.lead([&](double t) { return turned(std::min(1.0, t / 0.05) * half); }, 0.1);
  }

  static Pose turned(double angle) { return {glm::dvec3(0.0), fromRotationVector({0.0, 0.0, angle})}; }

  /// rad that the pin lags behind after a whole turn in a second, from half a facet on.
  double lagAfterTurn() {
    const double half = std::numbers::pi / fit.segments;
    rig.lead([&](double t) { return turned(half + 2.0 * std::numbers::pi * t); }, 1.0);
    return std::abs(rotationVector(rig.pose(0).orientation).z - half);
  }

  /// m, how far from the axis the pin comes to rest when it is pushed aside with some 1 N.
  double restAside(double direction) {
    const glm::dvec3 way{std::cos(direction), std::sin(direction), 0.0};
    rig.lead(
        [&](double t) {
          Pose pose = turned(std::numbers::pi / fit.segments);
          pose.position = std::min(1.0, t / 0.05) * 1e-3 * way;
          return pose;
        },
        0.1);
    return glm::dot(rig.pose(0).position, way);
  }

  ExactFit fit;
  MovingRig rig;
  double deepest = -1.0;             // m, of the exact pin in the exact block
  double force = 0.0, torque = 0.0;  // N, N·m, the largest on the hand

 private:
  void note() {
    // The block's ends are where a leaning pin is deepest.
    for (const double z : {0.0, -fit.height}) {
      const glm::dvec3 p = transformPoint(rig.pose(0), {0.0, 0.0, z});
      deepest = std::max(deepest, std::hypot(p.x, p.y) - fit.play);
    }
    force = std::max(force, glm::length(rig.out.hands[0].toHand.force));
    torque = std::max(torque, glm::length(rig.out.hands[0].toHand.torque));
  }
};

TEST(ExactFits, APinTurnsFreelyAndHasItsPlay) {
  ExactFitRig fit({});
  EXPECT_LT(fit.lagAfterTurn(), 2e-3);
  EXPECT_LT(fit.force, kFree);
  EXPECT_LT(fit.torque, kFree);
  double least = 1.0, most = 0.0;
  for (int k = 0; k < 12; ++k) {
    const double aside = fit.restAside(2.0 * std::numbers::pi * (k + 0.37 * (k % 3)) / 12);
    least = std::min(least, aside);
    most = std::max(most, aside);
  }
  EXPECT_NEAR(least, fit.fit.play, 1e-6);
  EXPECT_NEAR(most, fit.fit.play, 1e-6);
  EXPECT_LE(fit.deepest, 5e-6);
  std::printf("play felt %.2f to %.2f um, deepest %.2f um, turned with %.4f N m\n", 1e6 * least, 1e6 * most,
              1e6 * fit.deepest, fit.torque);
}

TEST(ExactFits, ByFacetsItJams) {
  // The control: the same file without its cylinders.
  ExactFitRig fit({.exact = false});
  fit.lagAfterTurn();
  EXPECT_GT(fit.torque, 100.0 * kFree);
  EXPECT_LT(fit.restAside(0.3), 1e-6);
}

}  // namespace
}  // namespace tandem::test
