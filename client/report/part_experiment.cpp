#include "client/report/part_experiment.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/constants.h"
#include "assets/generate/shapes.h"

namespace tandem::client::report {
namespace {

constexpr double kDensity = 7850.0;  // kg/m^3, steel

double smooth(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

/// A box around the origin, each face of n x n squares.
assets::TriangleSoup box(const glm::dvec3& size, int n) {
  assets::TriangleSoup soup;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto first = static_cast<std::uint32_t>(soup.positions.size());
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (int j = 0; j <= n; ++j) {
        for (int i = 0; i <= n; ++i) {
          glm::dvec3 p;
          p[axis] = 0.5 * side * size[axis];
          p[u] = size[u] * (static_cast<double>(i) / n - 0.5) * side;
          p[v] = size[v] * (static_cast<double>(j) / n - 0.5);
          soup.positions.push_back(p);
        }
      }
      const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(j * (n + 1) + i); };
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
          soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
      }
    }
  }
  soup.triangleMaterial.assign(soup.triangles.size(), 0);
  return soup;
}

void addParts(PartExperiment& e, assets::TriangleSoup held, assets::TriangleSoup other,
              const glm::dquat& turned = {1.0, 0.0, 0.0, 0.0}) {
  addParts(e, assets::analyseMesh(std::move(held), 0.5).mesh, assets::analyseMesh(std::move(other), 0.5).mesh,
           turned);
}

/// Sets the exact force: the spring between the hand's target and an ideal part that is held back along some
/// axes (1 in `held`) and follows without lag along the others (0). Of a part that touches others the hand
/// does not feel the damper.
void pushBack(PartExperiment& e, std::size_t i, const glm::dvec3& ideal, const glm::dvec3& held) {
  ASSERT(i < e.path.size());
  e.path[i].exactForce = held * (e.stiffness * (ideal - e.path[i].goal));
}

constexpr double kPegRadius = 10.0 * kMillimetre, kPegClearance = 0.01 * kMillimetre;  // radial
constexpr double kPegLength = 40.0 * kMillimetre, kEngaged = 30.0 * kMillimetre;

/// How a round surface is divided.
struct Cut {
  int sides, layers;
};
constexpr Cut kFine{320, 29}, kQuick{160, 13};  // 20 k and 4.5 k triangles

/// A peg along +y (shapes.h maps z to y). The face of its tip lies in y = 0 and has a chamfer of 1 mm.
assets::TriangleSoup peg(const Cut& cut) {
  std::vector<generate::ProfilePoint> profile{{0.0, 0.0}, {kPegRadius - kMillimetre, 0.0}};
  for (int i = 0; i <= cut.layers; ++i)
    profile.push_back({kPegRadius, kMillimetre + (kPegLength - kMillimetre) * i / cut.layers});
  profile.push_back({0.0, kPegLength});
  generate::Solid solid;
  solid.revolve(profile, cut.sides);
  return solid.soup();
}

/// A square block of 30 mm with its top in y = 0 and a blind bore. The middles of the bore's sides lie on its
/// circle.
assets::TriangleSoup boredBlock(const Cut& cut) {
  constexpr double kHalf = 15.0 * kMillimetre, kHeight = 45.0 * kMillimetre, kDepth = 40.0 * kMillimetre;
  const generate::Loop bore = generate::circleAround(kPegRadius + kPegClearance, cut.sides);
  generate::Loop square;
  for (glm::dvec2 p : generate::circle(1.0, cut.sides))
    square.push_back(p * (kHalf / glm::max(std::abs(p.x), std::abs(p.y))));
  const generate::Loop middle(bore.size(), glm::dvec2(0.0));
  generate::Solid solid;
  solid.band(middle, -kHeight, square, -kHeight);
  solid.band(square, -kHeight, square, 0.0);
  solid.band(square, 0.0, bore, 0.0);
  for (int i = 0; i < cut.layers; ++i)
    solid.band(bore, -kDepth * i / cut.layers, bore, -kDepth * (i + 1) / cut.layers);
  solid.band(bore, -kDepth, middle, -kDepth);
  return solid.soup();
}

/// The hand leads the peg aside, 20 um beyond its clearance, and slowly round in that position. The polygons
/// of peg and bore have their corners in the same directions, so the peg's origin may be anywhere within a
/// polygon of as many sides; rotation gives it no more room.
PartExperiment pegInBore(int ticks, const Cut& cut) {
  PartExperiment e;
  const double room = kPegRadius + kPegClearance - kPegRadius * std::cos(kPi / cut.sides);
  const double aside = kPegClearance + 0.02 * kMillimetre;
  for (int i = 0; i < ticks; ++i) {
    const double angle = 0.3 + 0.5 * kDt * std::max(0, i - 150), out = aside * smooth(i / 100.0);
    const glm::dvec2 goal = out * glm::dvec2(std::cos(angle), std::sin(angle));
    const glm::dvec2 ideal = insidePolygon(goal, room, cut.sides);
    PartPathPoint& point = e.path.emplace_back();
    // The polygon's y axis is -z of the scene.
    point.goal = {goal.x, -kEngaged, -goal.y};
    point.contact = point.force = i >= 300;
    point.depth = true;
    pushBack(e, e.path.size() - 1, {ideal.x, -kEngaged, -ideal.y}, glm::dvec3(1.0));
  }
  // The grip is in the middle of the part of the peg that is in the bore, so that the wall's force does not
  // tilt it.
  e.grip = {0.0, 0.5 * (kEngaged + kMillimetre), 0.0};
  addParts(e, peg(cut), boredBlock(cut));
  return e;
}

/// The cube is pressed 1 mm into the block's top and led round a circle of 15 mm at 100 mm/s.
PartExperiment slidingCube(int ticks) {
  constexpr double kSide = 10.0 * kMillimetre, kCircle = 15.0 * kMillimetre, kSpeed = 0.1;
  PartExperiment e;
  const double mass = kDensity * kSide * kSide * kSide;
  double travelled = 0.0;
  for (int i = 0; i < ticks; ++i) {
    travelled += kDt * kSpeed * smooth((i - 150) / 200.0);
    const glm::dvec2 out(std::cos(travelled / kCircle), std::sin(travelled / kCircle));
    PartPathPoint& point = e.path.emplace_back();
    point.goal =
        glm::dvec3(kCircle * out, 0.5 * kSide + 0.1 * kMillimetre - 1.1 * kMillimetre * smooth(i / 100.0));
    point.contact = i >= 150;
    point.force = i >= 450;
    point.depth = true;
    pushBack(e, e.path.size() - 1, {0.0, 0.0, 0.5 * kSide}, {0.0, 0.0, 1.0});
    // The centrifugal force draws the hand outwards.
    point.exactForce += glm::dvec3(mass * kSpeed * kSpeed / kCircle * out, 0.0);
  }
  assets::TriangleSoup block = box(glm::dvec3(60.0 * kMillimetre), 24);
  for (glm::dvec3& p : block.positions) p.z -= 30.0 * kMillimetre;
  addParts(e, box(glm::dvec3(kSide), 8), std::move(block));
  return e;
}

/// The plate goes from 5 mm above to 20 mm below at 200 mm/s, rests, and goes back, again and again.
PartExperiment plateOnPlate(int ticks) {
  constexpr double kThick = 0.5 * kMillimetre, kSpeed = 0.2, kTop = 5.0 * kMillimetre,
                   kLow = -20.0 * kMillimetre;
  constexpr int kStroke = 125, kRest = 75, kPeriod = 2 * (kStroke + kRest);
  PartExperiment e;
  for (int i = 0; i < ticks; ++i) {
    const int phase = i % kPeriod;
    const double down = kTop - kSpeed * kDt * phase, up = kLow + kSpeed * kDt * (phase - kStroke - kRest);
    const double z = phase < kStroke + kRest ? std::max(kLow, down) : std::min(kTop, up);
    PartPathPoint& point = e.path.emplace_back();
    point.goal = {3.0 * kMillimetre, -2.0 * kMillimetre, z};
    // The plate lands in the 23rd millisecond and must be at rest 40 ms later. On the way up the damper lifts
    // it off before the hand reaches the floor.
    point.contact = z < (phase < kStroke ? 0.2 : -2.0) * kMillimetre;
    point.force = z < -2.0 * kMillimetre && phase >= 65;
    point.depth = true;
    pushBack(e, e.path.size() - 1, {0.0, 0.0, std::max(z, kThick)}, {0.0, 0.0, 1.0});
  }
  e.targetDepth = 20e-6;
  addParts(e, box({40.0 * kMillimetre, 40.0 * kMillimetre, kThick}, 8),
           box({60.0 * kMillimetre, 60.0 * kMillimetre, kThick}, 8), fromRotationVector({0.0, 0.0, 0.5}));
  return e;
}

/// A cube of 5 mm is grasped inside a block of 60 mm, 20 mm from its middle. The shortest displacement out of
/// the block is along +x.
PartExperiment cubeInBlock() {
  constexpr double kSide = 5.0 * kMillimetre, kBlock = 60.0 * kMillimetre;
  constexpr int kOut = 1700, kTicks = 2000;  // by then it is out
  PartExperiment e;
  for (int i = 0; i < kTicks; ++i) {
    PartPathPoint& point = e.path.emplace_back();
    point.goal = glm::dvec3(20.0, 3.0, -1.0) * kMillimetre;
    point.contact = i >= 100;
    point.force = point.depth = i >= kOut;
    pushBack(e, e.path.size() - 1, {0.5 * (kBlock + kSide), 0.0, 0.0}, {1.0, 0.0, 0.0});
  }
  addParts(e, box(glm::dvec3(kSide), 4), box(glm::dvec3(kBlock), 24));
  return e;
}

}  // namespace

void addParts(PartExperiment& e, assets::Mesh held, assets::Mesh other, const glm::dquat& turned,
              const glm::dquat& otherTurned) {
  e.scene.materials.emplace_back().name = "smooth";
  for (assets::Mesh* mesh : {&held, &other}) {
    assets::Part part;
    part.name = mesh == &held ? "held" : "other";
    part.mesh = static_cast<std::uint32_t>(e.scene.meshes.size());
    part.movable = mesh == &held;
    if (part.movable) part.massProperties = assets::massProperties(*mesh, kDensity);
    part.worldFromPart = {part.movable ? e.path.front().goal : glm::dvec3(0.0),
                          part.movable ? turned : otherTurned};
    e.scene.meshes.push_back(std::move(*mesh));
    for (const glm::dvec3& p : e.scene.meshes.back().positions)
      e.scene.bounds.include(transformPoint(part.worldFromPart, p));
    e.scene.parts.push_back(part);
  }
}

glm::dvec2 insidePolygon(const glm::dvec2& goal, double inner, int sides) {
  ASSERT(inner > 0.0 && sides >= 3);
  // Coordinates along and across the side nearest to the goal. The middle of a side is half a step from a
  // corner.
  const double step = 2.0 * kPi / sides;
  const double middle = (std::floor(std::atan2(goal.y, goal.x) / step) + 0.5) * step;
  const glm::dvec2 outward(std::cos(middle), std::sin(middle)), along(-outward.y, outward.x);
  if (glm::dot(goal, outward) <= inner) return goal;
  const double half = inner * std::tan(0.5 * step);
  return inner * outward + std::clamp(glm::dot(goal, along), -half, half) * along;
}

std::vector<ExperimentInfo> allPartExperiments() {
  std::vector<ExperimentInfo> all;
  const auto add = [&](const char* id, const char* title, const char* about) {
    all.push_back({id, "held", title, about, true, 0.0, 0.0});
  };
  add("held-peg", "Peg in its bore",
      "A peg of 20 mm x 40 mm stands 30 mm deep in a bore that is 0.02 mm wider; the hand leads it 20 µm "
      "further "
      "aside than it has room, and that way slowly round.");
  add("held-slide", "Cube on a block",
      "A cube of 10 mm, pressed on with 1 N, slides over a block at 100 mm/s, across the seams of its "
      "triangles.");
  add("held-plates", "Plate on plate",
      "The hand leads a plate of 0.5 mm at 200 mm/s down onto another one and 20 mm further, rests, and goes "
      "back.");
  add("held-inside", "Cube inside a block",
      "A cube of 5 mm lies wholly inside a block of 60 mm when it is taken; it must come out the nearest "
      "way.");
  return all;
}

PartExperiment buildPartExperiment(const std::string& id, int ticks, bool quick) {
  ASSERT(ticks > 0);
  PartExperiment e;
  if (id == "held-peg") e = pegInBore(ticks, quick ? kQuick : kFine);
  if (id == "held-slide") e = slidingCube(ticks);
  if (id == "held-plates") e = plateOnPlate(ticks);
  if (id == "held-inside") e = cubeInBlock();
  for (const ExperimentInfo& info : allPartExperiments())
    if (info.id == id) e.info = info;
  ASSERT(e.info.id == id);  // one of allPartExperiments()
  return e;
}

}  // namespace tandem::client::report
