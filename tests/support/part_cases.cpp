#include "tests/support/part_cases.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "assets/base/constants.h"

namespace tandem::test {
namespace {

constexpr double kBlockWidth = 0.03;  // m, of the block round a peg's bore

Pose at(const glm::dvec3& position, const glm::dvec3& turn = glm::dvec3(0.0)) {
  return {position, fromRotationVector(turn)};
}

double between(std::mt19937& random, double least, double most) {
  return std::uniform_real_distribution<double>(least, most)(random);
}

/// A case whose first part is held; the part starts where its path does.
PartCase caseOf(const std::string& name, std::vector<CasePart> parts, DevicePath path, double duration) {
  parts[0].movable = true;
  parts[0].worldFromPart = path(0.0);
  return {name, sceneOfParts(parts), 0, std::move(path), duration, {}};
}

/// A number as part of a file's name: 0.02 -> "0p02".
std::string label(double value) {
  std::string text = std::to_string(value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  std::replace(text.begin(), text.end(), '.', 'p');
  return text;
}

}  // namespace

assets::Scene sceneOfParts(const std::vector<CasePart>& parts) {
  assets::Scene scene;
  for (const CasePart& given : parts) {
    assets::Material material;
    material.name = given.name;
    material.staticFriction = material.dynamicFriction = given.friction;
    scene.materials.push_back(material);
    assets::Part part;
    part.name = given.name;
    part.mesh = static_cast<std::uint32_t>(scene.meshes.size());
    part.worldFromPart = given.worldFromPart;
    part.movable = given.movable;
    if (given.movable) {
      part.massProperties = assets::massProperties(given.mesh, given.density);
      if (given.mass > 0.0) {
        part.massProperties.inertia *= given.mass / part.massProperties.mass;
        part.massProperties.mass = given.mass;
      }
    }
    scene.meshes.push_back(given.mesh);
    for (std::uint16_t& m : scene.meshes.back().triangleMaterial) {
      m = static_cast<std::uint16_t>(scene.materials.size() - 1);
    }
    for (const glm::dvec3& p : given.mesh.positions) {
      const glm::dvec3 q = transformPoint(given.worldFromPart, p);
      scene.bounds.include(q);
    }
    scene.parts.push_back(part);
  }
  return scene;
}

Tremor::Tremor(std::uint32_t seed, double amplitude, double lever) : amplitude_(amplitude), lever_(lever) {
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < 6; ++i) {
    frequency_[i] = between(random, 8.0, 12.0);
    phase_[i] = between(random, 0.0, 2.0 * kPi);
  }
}

double Tremor::value(std::size_t axis, double time) const {
  return amplitude_ * std::sin(2.0 * kPi * frequency_[axis] * time + phase_[axis]);
}
glm::dvec3 Tremor::shift(double time) const { return {value(0, time), value(1, time), value(2, time)}; }
glm::dvec3 Tremor::turn(double time) const {
  return glm::dvec3(value(3, time), value(4, time), value(5, time)) / lever_;
}

PartCase pegCase(const PegCase& peg) {
  std::mt19937 random(peg.seed);
  const double tilt = between(random, peg.tiltLeast, peg.tiltMost) * kPi / 180.0;
  const double tiltTo = between(random, 0.0, 2.0 * kPi), offsetTo = between(random, 0.0, 2.0 * kPi);
  const double offset = between(random, peg.offsetLeast, peg.offsetMost);
  const double anySpin = between(random, 0.0, 2.0 * kPi), spin = peg.spin < 0.0 ? anySpin : peg.spin;
  const Tremor tremor(peg.seed + 1000, peg.tremor);
  const Facets facets = peg.segments > 0 ? Facets{peg.segments, 4} : facetsFor(peg.triangles);
  const DevicePath path = [=, depth = peg.depth](double time) {
    const glm::dvec3 way{offset * std::cos(offsetTo), offset * std::sin(offsetTo),
                         std::max(-depth, 0.003 - 0.02 * time)};
    const glm::dvec3 lean = tilt * glm::dvec3(std::cos(tiltTo), std::sin(tiltTo), 0.0);
    Pose pose = at(way + tremor.shift(time), lean + tremor.turn(time));
    pose.orientation = pose.orientation * fromRotationVector({0.0, 0.0, spin});
    return pose;
  };
  const double clearance = 0.5 * peg.diametralClearance;
  return caseOf(
      "peg_" + label(1e3 * peg.diametralClearance) + "mm_" + std::to_string(peg.triangles) + "_mu" +
          label(peg.friction) + "_seed" + std::to_string(peg.seed) +
          (peg.segments > 0 ? "_segments" + std::to_string(peg.segments) : ""),
      {{"peg", meshOf(pegSoup({kPegRadius, 0.04, 0.001, facets})), {}, true, peg.friction},
       {"block",
        meshOf(boredBlockSoup({kPegRadius + clearance, 0.045, kBlockWidth, 0.045, 0.0, peg.fit, facets})),
        {},
        false,
        peg.friction}},
      path, (0.003 + peg.depth) / 0.02 + peg.settle);
}

namespace {

/// A peg and its bore of 0.1 mm clearance, both with some friction.
std::vector<CasePart> pegAndBlock(double clearance, double friction, int triangles = 1'500) {
  const Facets facets = facetsFor(triangles);
  return {{"peg", meshOf(pegSoup({kPegRadius, 0.04, 0.001, facets})), {}, true, friction},
          {"block",
           meshOf(boredBlockSoup(
               {kPegRadius + 0.5 * clearance, 0.045, kBlockWidth, 0.045, 0.0, Fit::around, facets})),
           {},
           false,
           friction}};
}

CasePart cube(double size, int n = 2) { return {"cube", meshOf(boxSoup(glm::dvec3(size), n)), {}, true}; }

/// A block of 60 mm whose top is z = 0.
assets::TriangleSoup blockBelow() { return moved(boxSoup(glm::dvec3(0.06), 7), {0.0, 0.0, -0.03}); }

}  // namespace

PartCase pegOnTopCase() {
  return caseOf(
      "peg_on_top", pegAndBlock(0.1e-3, 0.0),
      [](double time) {
        return at({0.002, 0.0, std::max(-0.002, 0.001 - 0.02 * time)});
      },
      0.6);
}

PartCase jamCase(const JamCase& jam) {
  const double lean = jam.moment / 4.0;
  const auto path = [=](double time) {
    const double since = time - jam.start();
    const double straight = jam.pullsOut ? std::clamp((since - jam.pushed) / 0.2, 0.0, 1.0) : 0.0;
    const double out = jam.pullsOut ? std::max(0.0, since - jam.pushed - 0.2) : 0.0;
    const double down = kJamPushSpeed * std::clamp(since - 0.3, 0.0, jam.pushed - 0.3) * (1.0 - straight);
    const double turn = lean * std::clamp(since / 0.2, 0.0, 1.0) * (1.0 - straight);
    const double above = jam.takenInside ? -jam.engaged : std::max(-jam.engaged, 0.001 - 0.1 * time);
    return at({0.0, 0.0, above - down + 0.05 * out}, {turn, 0.0, 0.0});
  };
  return caseOf(std::string(jam.pullsOut ? "wedged_comes_out" : "jam") + "_mu" + label(jam.friction) + "_l" +
                    label(1e3 * jam.engaged) + (jam.takenInside ? "_inside" : ""),
                pegAndBlock(0.1e-3, jam.friction), path,
                jam.start() + jam.pushed + (jam.pullsOut ? 0.4 + jam.engaged / 0.05 : 0.0));
}

PartCase plateOnPlateCase(double speed, std::uint32_t seed) {
  std::mt19937 random(seed);
  const glm::dvec3 lean{between(random, -0.05, 0.05), between(random, -0.05, 0.05),
                        between(random, -1.0, 1.0)};
  const glm::dvec2 aside{between(random, -0.01, 0.01), between(random, -0.01, 0.01)};
  return caseOf(
      "plate_" + label(speed) + "_seed" + std::to_string(seed),
      {{"plate", meshOf(boxSoup({0.04, 0.04, 0.0005}, 3)), {}, true},
       {"floor", meshOf(boxSoup({0.06, 0.06, 0.0005}, 4))}},
      [=](double time) { return at(glm::dvec3(aside, std::max(-0.02, 0.005 - speed * time)), lean); },
      0.025 / speed + 0.3);
}

PartCase cubeInBlockCase(const glm::dvec3& where) {
  return caseOf(
      "cube_in_block", {cube(0.005), {"block", meshOf(boxSoup(glm::dvec3(0.06), 4))}},
      [=](double) { return at(where); }, 2.0);
}

PartCase pegAlongRimCase() {
  const Facets fine{kRimSegments, 1};
  const double lean = 20.0 * kPi / 180.0, radius = 0.003, bore = 0.010;
  // The peg's axis leans out; its side would touch the rim with the axis `clear` from it, and is led 0.5 mm
  // further.
  const double clear = radius / std::cos(lean), below = 0.015;
  const double tip = bore - clear - below * std::tan(lean) + 0.0005;
  const auto path = [=](double time) {
    const double press = std::clamp(time / 0.1, 0.0, 1.0), angle = kPi * std::max(0.0, time - 0.2);
    const double out = tip - 0.001 * (1.0 - press);
    Pose pose = at({out * std::cos(angle), out * std::sin(angle), -below},
                   {-lean * std::sin(angle), lean * std::cos(angle), 0.0});
    return pose;
  };
  return caseOf(
      "peg_along_rim",
      {{"peg", meshOf(pegSoup({radius, 0.04, 0.0, fine})), {}, true},
       {"block", meshOf(boredBlockSoup({bore, 0.045, kBlockWidth, 0.045, 0.0, Fit::around, fine}))}},
      path, 2.2);
}

PartCase coplanarSlideCase(double speed) {
  const glm::dvec2 along = glm::normalize(glm::dvec2(1.0, 0.37));
  return caseOf(
      "coplanar_slide", {cube(0.01), {"block", meshOf(blockBelow())}},
      [=](double time) {
        const double down = 0.0011 * std::clamp(time / 0.1, 0.0, 1.0);
        const glm::dvec2 there = along * (-0.015 + speed * std::max(0.0, time - 0.2));
        return at(glm::dvec3(there, 0.0051 - down));
      },
      0.2 + 0.03 / speed);
}

PartCase threeBlocksCase(double push) {
  // A slot of 30 mm along y whose floor is z = 0; two blocks of 10.1 mm at its walls leave 9.8 mm.
  const assets::Mesh block = meshOf(boxSoup({0.0101, 0.01, 0.01}, 2));
  return caseOf(
      "three_blocks",
      {cube(0.01),
       {"left", block, at({-0.00995, 0.0, 0.005})},
       {"right", block, at({0.00995, 0.0, 0.005})},
       {"slot", meshOf(slotSoup(0.03, 0.015, 0.005, 0.06))}},
      [=](double time) {
        const double down = std::min(push, 0.1 * time);
        return at({0.0, 0.0, 0.0155 - down}, {0.0, 0.02, 0.01});
      },
      push / 0.1 + 1.0);
}

PartCase dirtyShellsCase(Dirt dirt) {
  assets::TriangleSoup block = blockBelow();
  const char* names[] = {"clean", "inside_out", "flipped", "torn"};
  if (dirt == Dirt::insideOut) block = insideOut(block);
  if (dirt == Dirt::flipped) block = shattered(block, 3);
  if (dirt == Dirt::torn) block = shattered(block, 0, 41);
  PartCase made = caseOf(
      std::string("shell_") + names[static_cast<int>(dirt)], {cube(0.01), {"block", meshOf(block)}},
      [](double time) {
        return at({0.003, -0.002, 0.0051 - 0.0011 * std::clamp(time / 0.1, 0.0, 1.0)});
      },
      0.5);
  made.asFiled = block;
  return made;
}

PartCase cubeAtRestCase() {
  return caseOf(
      "cube_at_rest", {cube(0.01), {"block", meshOf(blockBelow())}},
      [](double) {
        return at({0.003, -0.002, 0.005});
      },
      0.3);
}

PartCase pegAtRestCase() {
  // A corner of the peg on the middle of a side of the bore.
  const double turn = kPi / facetsFor(1'500).segments;
  const glm::dvec2 aside = 0.00005 * glm::dvec2(std::cos(turn), std::sin(turn));
  return caseOf(
      "peg_at_rest", pegAndBlock(0.1e-3, 0.0),
      [=](double) {
        return at(glm::dvec3(aside, -0.02), {0.0, 0.0, turn});
      },
      0.3);
}

std::vector<PartCase> allPartCases() {
  std::vector<PartCase> cases;
  for (const double clearance : {0.5e-3, 0.1e-3, 0.02e-3}) {
    for (const std::uint32_t seed : {0u, 1u}) cases.push_back(pegCase({clearance, 5'000, seed}));
    cases.push_back(pegCase({clearance, 50'000, 0u}));
  }
  cases.push_back(pegOnTopCase());
  cases.push_back(jamCase({}));
  cases.push_back(jamCase({.engaged = 0.01, .moment = 0.1, .friction = 0.1}));
  cases.push_back(jamCase({.pushed = 1.5, .pullsOut = true}));
  for (const double speed : {0.2, 1.0, 2.0}) cases.push_back(plateOnPlateCase(speed, 0));
  cases.push_back(cubeInBlockCase({0.02, 0.003, -0.001}));
  cases.push_back(pegAlongRimCase());
  cases.push_back(coplanarSlideCase(0.1));
  cases.push_back(threeBlocksCase(0.03));
  for (const Dirt dirt : {Dirt::none, Dirt::insideOut, Dirt::flipped, Dirt::torn}) {
    cases.push_back(dirtyShellsCase(dirt));
  }
  cases.push_back(cubeAtRestCase());
  cases.push_back(pegAtRestCase());
  return cases;
}

}  // namespace tandem::test
