#include "tests/simulation/chain_sessions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "client/simulation/split_mix.h"
#include "tests/simulation/shared_sessions.h"

namespace tandem::test {
namespace {

using nlohmann::json;

constexpr double kSize = 0.05, kGap = 0.005, kPitch = kSize + kGap;  // m
constexpr double kFirst = -0.15;                                     // m
constexpr double kGripHeight = 0.06;                                 // m, over the centres
constexpr double kPushBegins = 2.0, kPushEnds = 6.0;                 // s

/// Where a box is: its column along the push, and the lanes beside each other that it takes.
struct Place {
  std::size_t column = 0, firstLane = 0, lanes = 1;
  double x() const { return kFirst + kPitch * static_cast<double>(column); }
  double y() const {
    return kPitch * (static_cast<double>(firstLane) + 0.5 * static_cast<double>(lanes - 1));
  }
  double width() const { return kPitch * static_cast<double>(lanes) - kGap; }
};

/// A box is as wide as all that are next to it.
std::vector<Place> placesOf(const Chain& chain) {
  const std::size_t count = chain.masses.size();
  std::vector<Place> places(count);
  std::vector<std::vector<std::size_t>> next(count);
  for (std::size_t i = 1; i < count; ++i) {
    const std::size_t of = chain.shape == Chain::Shape::row ? i - 1 : chain.nextTo[i];
    next[of].push_back(i);
    places[i].column = places[of].column + 1;
  }
  for (std::size_t i = count; i-- > 0;) {
    places[i].lanes = next[i].empty() ? 1 : 0;
    for (const std::size_t other : next[i]) places[i].lanes += places[other].lanes;
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t lane = places[i].firstLane;
    for (const std::size_t other : next[i]) {
      places[other].firstLane = lane;
      lane += places[other].lanes;
    }
  }
  if (chain.shape != Chain::Shape::merging) return places;
  std::size_t last = 0;
  for (const Place& place : places) last = std::max(last, place.column);
  for (Place& place : places) place.column = last - place.column;
  return places;
}

json partOf(const std::string& name, const glm::dvec3& at, std::size_t shape, double mass, double width) {
  json body = {{"collider", {{"geometry", {{"shape", shape}}}, {"physicsMaterial", 0}}}};
  const double thin = mass * kSize * kSize / 6.0, wide = mass * (kSize * kSize + width * width) / 12.0;
  if (mass > 0.0) body["motion"] = {{"mass", mass}, {"inertiaDiagonal", {wide, thin, wide}}};
  return {{"name", name},
          {"translation", {at.x, at.y, at.z}},
          {"extensions", {{"KHR_physics_rigid_bodies", body}}}};
}

json boxOf(double x, double y, double z) { return {{"type", "box"}, {"box", {{"size", {x, y, z}}}}}; }

std::string nameOf(std::size_t box) { return "p" + std::to_string(box); }

assets::Scene sceneOf(const Chain& chain) {
  const std::vector<Place> places = placesOf(chain);
  json nodes = json::array(), order = json::array(), shapes = json::array();
  std::size_t last = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& place = places[i];
    shapes.push_back(boxOf(kSize, place.width(), kSize));
    nodes.push_back(partOf(nameOf(i), {place.x(), place.y(), 0.0}, i, chain.masses[i], place.width()));
    last = std::max(last, place.column);
  }
  const auto addFixed = [&](const std::string& name, const glm::dvec3& at, const json& shape) {
    nodes.push_back(partOf(name, at, shapes.size(), 0.0, 0.0));
    shapes.push_back(shape);
  };
  const double end = Place{last}.x() + 0.5 * kSize + chain.toWall;
  if (chain.wall) addFixed("wall", {end + 0.02, 0.0, 0.0}, boxOf(0.04, 2.0, 0.3));
  if (chain.gravity) addFixed("table", {0.0, 0.0, -0.5 * kSize - 0.01}, boxOf(3.0, 3.0, 0.02));
  for (std::size_t i = 0; i < nodes.size(); ++i) order.push_back(i);
  const json material = {
      {"staticFriction", chain.friction}, {"dynamicFriction", chain.friction}, {"restitution", 0.0}};
  const json file = {{"asset", {{"version", "2.0"}}},
                     {"scene", 0},
                     {"scenes", json::array({{{"nodes", order}}})},
                     {"nodes", nodes},
                     {"extensionsUsed", {"KHR_physics_rigid_bodies", "KHR_implicit_shapes"}},
                     {"extensions",
                      {{"KHR_implicit_shapes", {{"shapes", shapes}}},
                       {"KHR_physics_rigid_bodies", {{"physicsMaterials", json::array({material})}}}}}};
  const std::string text = file.dump();
  Result<assets::Scene> scene = assets::loadGltfFromMemory("chain.gltf", {text.begin(), text.end()}, {});
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().message);
  if (!chain.gravity) scene->gravity = glm::dvec3(0.0);
  return std::move(*scene);
}

/// Grasps its box; a pusher then pushes it along and pulls it back.
json scriptOf(const Chain& chain, std::size_t box) {
  json script = json::array({{{"t", 0.4}, {"do", "grasp"}, {"part", nameOf(box)}, {"over_s", 0.3}}});
  if (std::find(chain.pushers.begin(), chain.pushers.end(), box) == chain.pushers.end()) return script;
  script.push_back(
      {{"t", kPushBegins}, {"do", "move_relative"}, {"by", {chain.push, 0.0, 0.0}}, {"over_s", chain.over}});
  script.push_back(
      {{"t", kPushEnds}, {"do", "move_relative"}, {"by", {-chain.push, 0.0, 0.0}}, {"over_s", 1.0}});
  return script;
}

client::Scenario scenarioOf(const Chain& chain) {
  const std::vector<Place> places = placesOf(chain);
  client::Scenario scenario;
  scenario.path = "chain";
  scenario.duration = 8.5;
  scenario.network.oneWay = static_cast<sync::Micros>(1e3 * chain.delay);
  scenario.network.jitter = 0.2;
  scenario.network.loss = 0.02;
  for (std::size_t i = 0; i < places.size(); ++i) {
    client::ScenarioSite& site = scenario.sites.emplace_back();
    site.name = "s" + std::to_string(i);
    site.arm = chain.arms.empty() ? chain.arm : chain.arms[i];
    site.device.forceMax = chain.deviceForce;
    site.stiffness = 1000.0;
    site.hasStart = true;
    site.start = {places[i].x(), places[i].y(), kGripHeight};
    site.script = scriptOf(chain, i).dump();
  }
  return scenario;
}

/// Random numbers of a chain.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}
  double in(double low, double high) {
    return low + (high - low) * static_cast<double>(random_.draw() >> 11) * 0x1p-53;
  }
  double inRatio(double low, double high) { return low * std::pow(high / low, in(0.0, 1.0)); }
  bool chance(double p) { return in(0.0, 1.0) < p; }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_.draw() % n); }

 private:
  client::SplitMix64 random_;
};

haptics::ArmParameters drawArm(Dice& dice) {
  return {1.5, dice.inRatio(48.8, 300.0), dice.in(4.5, 12.0), dice.in(375.0, 800.0), dice.in(7.9, 10.0)};
}

/// All boxes that nothing is next to: the ends of a tree.
std::vector<std::size_t> endsOf(const Chain& chain) {
  std::vector<std::size_t> ends;
  for (std::size_t i = 0; i < chain.masses.size(); ++i)
    if (std::find(chain.nextTo.begin() + 1, chain.nextTo.end(), i) == chain.nextTo.end()) ends.push_back(i);
  return ends;
}

/// The greatest change of a hand's force within 20 ms while some push.
class ForceSteps {
 public:
  void add(double t, std::span<const client::SimulatedSiteState> sites) {
    forces_.resize(sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) {
      std::vector<glm::dvec3>& of = forces_[i];
      of.push_back(sites[i].force);
      if (t > kPushBegins && t < kPushEnds) largest_ = std::max(largest_, changeIn20ms(of, of.size() - 1));
    }
  }
  double largest() const { return largest_; }

 private:
  std::vector<std::vector<glm::dvec3>> forces_;
  double largest_ = 0.0;
};

}  // namespace

Chain unequalChain(int owners) {
  Chain chain;
  for (int i = 0; i < owners; ++i) chain.masses.push_back(i % 2 == 0 ? 0.05 : 5.0);
  return chain;
}

Chain drawChain(std::uint64_t seed) {
  Dice dice(seed);
  Chain chain;
  const std::size_t owners = 2 + dice.below(7);
  const bool inTurn = dice.chance(0.5);
  for (std::size_t i = 0; i < owners; ++i) {
    chain.masses.push_back(inTurn ? (i % 2 == 0 ? 0.05 : 5.0) : dice.inRatio(0.05, 5.0));
    chain.nextTo.push_back(i == 0 ? 0 : dice.below(i));
    chain.arms.push_back(drawArm(dice));
  }
  chain.shape = static_cast<Chain::Shape>(dice.below(3));
  if (chain.shape == Chain::Shape::merging) chain.pushers = endsOf(chain);
  chain.delay = dice.inRatio(5.0, 250.0);
  chain.wall = dice.chance(0.5);
  chain.gravity = dice.chance(0.3);
  chain.friction = dice.chance(0.3) ? dice.in(0.0, 0.3) : 0.0;
  chain.push = dice.in(0.03, 0.08);
  return chain;
}

std::string describe(const Chain& chain) {
  static constexpr const char* kShapes[] = {"in a row", "splitting", "merging"};
  std::string text = std::to_string(chain.masses.size()) + " owners " +
                     kShapes[static_cast<std::size_t>(chain.shape)] + ", " + std::to_string(chain.delay) +
                     " ms, " + std::to_string(chain.deviceForce) + " N" + (chain.wall ? ", wall" : ", free");
  if (chain.gravity) text += ", on a table";
  if (chain.friction > 0.0) text += ", friction " + std::to_string(chain.friction);
  return text;
}

client::SimulationResult run(const Chain& chain, const client::SimulationOptions& options) {
  const assets::Scene scene = sceneOf(chain);
  haptics::ContactScene contact(scene);
  EXPECT_TRUE(contact.modelParts());
  Result<client::SimulationResult> result = client::simulate(scenarioOf(chain), contact, options);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
  return std::move(*result);
}

Chain aloneAtWall(const Chain& chain, std::size_t pusher) {
  std::size_t last = 0;
  const std::vector<Place> places = placesOf(chain);
  for (const Place& place : places) last = std::max(last, place.column);
  Chain alone = chain;
  alone.shape = Chain::Shape::row;
  alone.masses = {chain.masses[pusher]};
  alone.nextTo = {0};
  alone.pushers = {0};
  alone.wall = true;
  alone.toWall += kGap * static_cast<double>(last - places[pusher].column);
  if (!chain.arms.empty()) alone.arms = {chain.arms[pusher]};
  return alone;
}

ChainFigures measure(const Chain& chain, std::uint64_t seed, client::Mistake mistake) {
  ForceSteps steps;
  client::SimulationOptions options;
  options.leaderLoad = false;
  options.seed = seed;
  options.mistake = mistake;
  options.watch = [&](double t, std::span<const client::SimulatedSiteState> sites) { steps.add(t, sites); };
  const client::SimulationResult result = run(chain, options);
  return {result.energyCreated, steps.largest(), result.discrepancyMax, result.violations.size()};
}

}  // namespace tandem::test
