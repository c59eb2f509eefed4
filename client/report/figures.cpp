#include "client/report/figures.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include <glm/geometric.hpp>

#include "assets/base/percentiles.h"
#include "assets/generate/bench_meshes.h"
#include "client/report/bare_spring.h"
#include "client/report/targets.h"
#include "haptics/geometry/triangle_bvh.h"
#include "haptics/operator/simulated_hand.h"
#include "haptics/scene/contact_scene.h"
#include "haptics/tick.h"

namespace tandem::client::report {
namespace {

constexpr double kTick = 1e-3, kPush = 1.0;  // s, N
constexpr haptics::SimulatedDeviceParameters kDevice{};
constexpr double kMass = kDevice.mass, kQuantum = kDevice.quantum;

/// A hand on a scene, given by its position alone.
class Hand {
 public:
  Hand(const assets::Scene& scene, const haptics::TickParameters& p)
      : contact_(scene, 1), parameters_(p), state_(contact_) {}

  const haptics::TickOutput& at(const glm::dvec3& position) {
    haptics::TickInput input;
    input.hands[0].device.worldFromDevice.position = position;
    input.hands[0].device.time = time_ += kTick;
    input.hands[0].device.valid = true;
    return out_ = haptics::tick(input, contact_, parameters_, state_);
  }

 private:
  haptics::ContactScene contact_;
  haptics::TickParameters parameters_;
  haptics::TickState state_;
  haptics::TickOutput out_;
  double time_ = 0.0;
};

/// The ratio of tangential to normal force of a tool that strokes a sphere of 20,000 triangles 2 mm deep,
/// against the coefficient. The normal is the sphere's, so that the tilt of the facets counts as an error.
void sphereFriction(std::vector<Figure>& out) {
  constexpr double kCoefficient = 0.3, kRadius = 0.05, kDepth = 2e-3;
  assets::Scene scene = generate::sceneOf(generate::sphereMesh(kRadius, 20'000));
  for (assets::Material& m : scene.materials) m.staticFriction = m.dynamicFriction = kCoefficient;
  Hand hand(scene, bareSpring(1000.0));
  std::vector<double> errors;
  double sum = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double azimuth = 2e-3 * i, polar = 1.3 + 0.4 * std::sin(0.37 * azimuth);
    const glm::dvec3 n(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                       std::cos(polar));
    const double down = std::min(1.0, i / 100.0);
    const haptics::TickOutput& felt = hand.at(n * (kRadius + 1e-3 - down * (1e-3 + kDepth)));
    if (i < 500) continue;
    const glm::dvec3 normal = glm::normalize(felt.worldFromProxy.position),
                     force = felt.hands[0].toHand.force;
    const double pressed = glm::dot(force, normal), ratio = glm::length(force - pressed * normal) / pressed;
    sum += ratio;
    errors.push_back(std::abs(ratio / kCoefficient - 1.0));
  }
  const double mean = sum / static_cast<double>(errors.size()) / kCoefficient;
  out.push_back({"friction-sphere-mean", "friction on a sphere of 20 k triangles: mean ratio, error of it",
                 "%", 100.0 * std::abs(mean - 1.0), 0.5, false});
  out.push_back({"friction-sphere-p99", "the same in one tick, p99: facets are tilted", "%",
                 100.0 * percentiles(errors).p99, 0.0, false});
}

void refit(std::vector<Figure>& out) {
  const assets::Mesh mesh = generate::sphereMesh(0.05, 100'000);
  haptics::TriangleBvh tree(mesh);
  double least = 1e300;
  for (int i = 0; i < 9; ++i) {
    const auto start = std::chrono::steady_clock::now();
    tree.refit();
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    least = std::min(least, took.count());
  }
  out.push_back({"refit-100k", "refit of a tree of 100 k triangles, all cores, least of 9", "ms", least,
                 kRefitTarget_ms, false});
}

struct Loop {
  double damping = 0.0, share = 0.0;  // N·s/m; of 2 b / T
  bool quantised = false, controlled = false;
};

/// Whether the oscillation of a device of 45 g, pressed onto a wall with 1 N, decays or stays within three
/// quanta of the reading in both directions. The motion between ticks is solved exactly.
bool staysBounded(const Loop& loop) {
  const assets::Scene scene = generate::sceneOf(generate::flatSheet(0.4, 2));
  haptics::TickParameters p = bareSpring(loop.share * 2.0 * loop.damping / kTick);
  p.passivity = loop.controlled;
  p.deviceDamping = 0.5 * loop.damping;
  Hand hand(scene, p);
  const double a = std::exp(-loop.damping * kTick / kMass);
  double z = 1e-3, v = 0.0, early[2] = {1.0, -1.0}, late[2] = {1.0, -1.0};
  for (int i = 0; i < 9000; ++i) {
    const double reading = loop.quantised ? kQuantum * std::floor(z / kQuantum + 0.5) : z;
    const double settled = (hand.at({0.0, 0.0, reading}).hands[0].toHand.force.z - kPush) / loop.damping;
    z += settled * kTick + (v - settled) * (1.0 - a) * kMass / loop.damping;
    v = settled + (v - settled) * a;
    if (!(std::abs(z) < 0.5)) return false;
    double* const swing = i >= 2000 && i < 3000 ? early : i >= 8000 ? late : nullptr;
    if (swing == nullptr) continue;
    swing[0] = std::min(swing[0], z);
    swing[1] = std::max(swing[1], z);
  }
  const double last = late[1] - late[0];
  return last <= 6.0 * kQuantum || last < 0.9 * (early[1] - early[0]);
}

/// The largest share of 2 b / T up to which every damping stays bounded, in steps of 0.05; at most 3.
double boundedUpTo(bool quantised, bool controlled) {
  double share = 0.0;
  for (; share < 3.0 - 1e-9; share += 0.05)
    for (const double damping : {0.1, 0.5, 1.0, 2.0})
      if (!staysBounded({damping, share + 0.05, quantised, controlled})) return share;
  return share;
}

void closedLoop(std::vector<Figure>& out) {
  for (const bool quantised : {false, true}) {
    const std::string reading = quantised ? ", quantum 0.055 mm" : ", exact reading";
    const std::string id = quantised ? "-quantised" : "-exact";
    out.push_back({"wall" + id, "stiffest bounded wall, b = 0.1 to 2 N·s/m" + reading, "x 2b/T",
                   boundedUpTo(quantised, false), 0.95, true});
    out.push_back({"wall-controlled" + id, "the same under the passivity controller (tried up to 3)",
                   "x 2b/T", boundedUpTo(quantised, true), 1.5, true});
  }
}

}  // namespace

std::vector<Figure> measureFigures(bool quick) {
  std::vector<Figure> out;
  sphereFriction(out);
  refit(out);
  if (!quick) closedLoop(out);
  return out;
}

}  // namespace tandem::client::report
