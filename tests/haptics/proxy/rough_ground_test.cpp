// A proxy over ground as rough as a scan, whose moves are bounded: it may come late, and not for long.

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/generate/bench_meshes.h"
#include "haptics/geometry/query_work.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

constexpr double kScanned = 0.01;  // m, radius of the scan
constexpr double kPressed = 2e-3;  // m under its waves
constexpr int kStrokeTicks = 2000;

/// A device position that goes around the scan at `speed` m/s, pressed into it.
glm::dvec3 aroundScan(double speed, double toolRadius, int tick) {
  const double a = 1e-3 * speed / kScanned * tick, b = 1e-4 * tick;
  const glm::dvec3 n(std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b));
  return n * (kScanned + generate::scanWave(kScanned, n) + toolRadius - kPressed);
}

struct RoughStroke {
  double meanForce = 0.0, meanSettled = 0.0;  // N; settled: of a proxy that has arrived at each place
  double off = 0.0;                           // N, 99th percentile of the difference
  double change = 0.0, changeSettled = 0.0;   // N, from tick to tick, 99th percentile
  double triangles = 0.0;                     // tested a tick, 99th percentile
};

double ninetyNinth(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() * 99 / 100];
}

/// A stroke of a ball or point beside one that ticks six times at each place.
RoughStroke strokeOverScan(const assets::Scene& scene, double speed, double toolRadius) {
  haptics::TickParameters parameters = springOnly();
  parameters.toolRadius = toolRadius;
  HandProbe hand(scene, parameters), settled(scene, parameters);
  const auto enter = [&](HandProbe& probe) {
    const glm::dvec3 start = aroundScan(speed, toolRadius, 0);
    probe.at(1.5 * start);
    probe.to(start, 1e-4);
    for (int i = 0; i < 10; ++i) probe.at(start);
  };
  enter(hand);
  enter(settled);
  RoughStroke out;
  std::vector<double> off, change, changeSettled, triangles;
  glm::dvec3 last = hand.out.hands[0].toHand.force, lastSettled = last;
  for (int i = 1; i <= kStrokeTicks; ++i) {
    const glm::dvec3 device = aroundScan(speed, toolRadius, i);
    const haptics::QueryWork before = haptics::queryWork;
    hand.at(device);
    triangles.push_back(static_cast<double>((haptics::queryWork - before).triangles));
    for (int k = 0; k < 6; ++k) settled.at(device);
    const glm::dvec3 force = hand.out.hands[0].toHand.force, exact = settled.out.hands[0].toHand.force;
    off.push_back(glm::distance(force, exact));
    change.push_back(glm::distance(force, last));
    changeSettled.push_back(glm::distance(exact, lastSettled));
    out.meanForce += glm::length(force) / kStrokeTicks;
    out.meanSettled += glm::length(exact) / kStrokeTicks;
    last = force;
    lastSettled = exact;
  }
  out.off = ninetyNinth(off);
  out.change = ninetyNinth(change);
  out.changeSettled = ninetyNinth(changeSettled);
  out.triangles = ninetyNinth(triangles);
  return out;
}

class RoughGround : public ::testing::Test {
 protected:
  void SetUp() override {
    SceneBuilder b;
    b.addPart(generate::scanMesh(kScanned, 250'000, 0.05, 3, generate::Topology::always), {});
    scene_ = b.scene;
  }
  assets::Scene scene_;
};

TEST_F(RoughGround, IsFeltAsByAProxyWithTimeAtAnySpeed) {
  for (const double toolRadius : {0.0, 1e-3}) {
    for (const double speed : {0.05, 0.2, 2.0}) {
      const RoughStroke s = strokeOverScan(scene_, speed, toolRadius);
      EXPECT_NEAR(s.meanForce, s.meanSettled, 5e-3 * s.meanSettled) << toolRadius << ' ' << speed;
      EXPECT_LT(s.change, 1.1 * s.changeSettled + 0.01) << toolRadius << ' ' << speed;
      EXPECT_LT(s.off, s.changeSettled) << toolRadius << ' ' << speed;
    }
  }
}

TEST_F(RoughGround, ASlowPointCostsLittle) {
  // 56 triangles a tick if each move may take 24 rounds.
  EXPECT_LE(strokeOverScan(scene_, 0.05, 0.0).triangles, 30.0);
}

}  // namespace
}  // namespace tandem::test
