// Two parts of the same size, flush with each other, pressed together again and again: every edge of one lies
// on an edge of the other, so that of each sample the nearest face may be one at its side.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "tests/haptics/contact/moving_rig.h"
#include "tests/haptics/contact/part_contact_case.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using assets::ImplicitShape;

constexpr double kHalfHeight = 0.02;    // m, of the height of either
constexpr double kPressedDeep = 10e-6;  // m
constexpr double kLift = 50e-6;  // m, of what should not rise at all; what is driven out rises by millimetres

const std::uint32_t kSeeds = atFullSize() ? 20 : 5;

struct Solid {
  const char* name;
  std::vector<ImplicitShape> shapes;
  assets::TriangleSoup soup;
};

Solid boxShape() {
  ImplicitShape shape;
  shape.kind = ImplicitShape::Kind::box;
  shape.size = {0.06, 2.0 * kHalfHeight, 0.03};
  return {"box", {shape}, {}};
}
Solid rodShape(double top, double bottom) {
  ImplicitShape shape;
  shape.kind = ImplicitShape::Kind::cylinder;
  shape.radiusTop = top;
  shape.radiusBottom = bottom;
  shape.height = 2.0 * kHalfHeight;
  return {top == bottom ? "cylinder" : "cone", {shape}, {}};
}
Solid meshOfBox() { return {"mesh of a box", {}, boxSoup({0.06, 2.0 * kHalfHeight, 0.03}, 2)}; }
/// Wider below, or above where it is upside down: where the wide ends meet, the sides of both lean away from
/// each other.
Solid wedgeMesh(double wider) {
  Solid solid = meshOfBox();
  solid.name = "mesh of a frustum";
  for (glm::dvec3& p : solid.soup.positions)
    if (p.y < 0.0) p *= glm::dvec3(wider, 1.0, wider);
  return solid;
}

assets::Scene stackOf(const Solid& upper, const Solid& lower) {
  assets::Scene scene;
  scene.materials.emplace_back();
  for (const Solid* solid : {&upper, &lower}) {
    assets::Part part;
    part.name = solid->name;
    part.shapes = solid->shapes;
    if (solid->shapes.empty()) {
      part.mesh = static_cast<std::uint32_t>(scene.meshes.size());
      scene.meshes.push_back(meshOf(solid->soup));
    }
    part.movable = true;
    part.massProperties.mass = 0.5;
    part.massProperties.inertia = glm::dmat3(2e-4);
    scene.parts.push_back(part);
  }
  scene.parts[0].worldFromPart.position.y = 2.0 * kHalfHeight + 0.001;
  scene.bounds.min = glm::dvec3(-0.1);
  scene.bounds.max = glm::dvec3(0.1);
  return scene;
}

/// Where the upper part is flush but for rounding.
struct Askew {
  glm::dvec3 aside{0.0, 0.0, 0.0};     // m
  glm::dvec3 rotation{0.0, 0.0, 0.0};  // rad
};

/// From 1e-12 to 1e-6 of either.
Askew drawn(std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto tiny = [&] {
    const double u = std::generate_canonical<double, 53>(random);
    const double v = std::generate_canonical<double, 53>(random);
    return (v < 0.5 ? -1.0 : 1.0) * std::pow(10.0, -12.0 + 6.0 * u);
  };
  Askew askew;
  askew.aside = {tiny(), 0.0, tiny()};
  askew.rotation = {tiny(), tiny(), tiny()};
  return askew;
}

/// m, how deep the upper part comes into the lower one: pressed by 0.5 N, let up until it barely rests, and
/// so on. `frees`: the lower part is moved here too and yields.
double deepestOf(const Solid& upper, const Solid& lower, const Askew& askew, bool frees = false) {
  assets::Scene scene = stackOf(upper, lower);
  scene.parts[0].worldFromPart.position += askew.aside;
  scene.parts[0].worldFromPart.orientation = fromRotationVector(askew.rotation);
  const Pose start = scene.parts[0].worldFromPart;
  MovingRig rig(std::move(scene));
  const auto path = [&](double t) {
    Pose pose = start;
    pose.position.y -= t < 0.2 ? 0.001 * t / 0.2 : 0.001 + 0.00025 * (1.0 - std::cos(20.0 * (t - 0.2)));
    return pose;
  };
  rig.at(path(0.0));
  rig.tick();
  rig.own(0);
  if (frees) rig.own(1);
  rig.grasp(0);
  double deepest = 0.0;
  rig.each = [&] {
    const glm::dvec3 rotation =
        rotationVector(glm::conjugate(rig.pose(1).orientation) * rig.pose(0).orientation);
    const glm::dvec3 offset = rig.pose(0).position - rig.pose(1).position;
    deepest = std::max(deepest, 2.0 * kHalfHeight - offset.y - 0.04 * glm::length(rotation));
  };
  rig.lead(path, frees ? 0.6 : 1.5);
  EXPECT_EQ(rig.flags & haptics::kFlagFault, 0u);
  return deepest;
}

const Solid& upsideDown(Solid& solid) {
  for (ImplicitShape& shape : solid.shapes) std::swap(shape.radiusTop, shape.radiusBottom);
  for (glm::dvec3& p : solid.soup.positions) p *= glm::dvec3(1.0, -1.0, -1.0);
  return solid;
}

TEST(AlignedParts, OfTheSameSizeDoNotComeIntoEachOther) {
  const Solid solids[] = {boxShape(),  rodShape(0.02, 0.02), rodShape(0.02, 0.015), rodShape(0.015, 0.02),
                          meshOfBox(), wedgeMesh(1.3),       wedgeMesh(0.7)};
  for (const Solid& solid : solids) {
    Solid below = solid;
    upsideDown(below);
    EXPECT_LT(deepestOf(solid, below, {}), kPressedDeep) << solid.name;
    double greatest = 0.0;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
      for (const bool frees : {false, true}) {
        const double deepest = deepestOf(solid, below, drawn(seed), frees);
        EXPECT_LT(deepest, kPressedDeep)
            << solid.name << ", seed " << seed << (frees ? ", that gives way" : "");
        greatest = std::max(greatest, deepest);
      }
    }
    if (atFullSize()) std::printf("%s: %.4f um deep\n", solid.name, 1e6 * greatest);
  }
}

TEST(AlignedParts, BoxOnMeshOfTheSameSizeAndTheOtherWayRound) {
  for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
    EXPECT_LT(deepestOf(boxShape(), meshOfBox(), drawn(seed)), kPressedDeep) << seed;
    EXPECT_LT(deepestOf(meshOfBox(), boxShape(), drawn(seed)), kPressedDeep) << seed;
  }
}

ImplicitShape boxAt(const glm::dvec3& size, const glm::dvec3& at) {
  ImplicitShape shape;
  shape.kind = ImplicitShape::Kind::box;
  shape.size = size;
  shape.partFromShape.position = at;
  return shape;
}

/// m, how far a block is at most lifted off what it slides on along z while it is led `down` below that.
double liftedFrom(const Solid& ground, const Solid& block, const glm::dvec3& start, const glm::dvec3& down) {
  assets::Scene scene = stackOf(block, ground);
  scene.parts[0].worldFromPart.position = start;
  const Pose from = scene.parts[0].worldFromPart;
  MovingRig rig(std::move(scene));
  const auto path = [&](double t) {
    Pose pose = from;
    pose.position += std::min(t / 0.1, 1.0) * down + glm::dvec3(0.0, 0.0, 0.02 * std::max(0.0, t - 0.1));
    return pose;
  };
  rig.ownAndGrasp(0, path(0.0));
  double lifted = 0.0;
  rig.each = [&] { lifted = std::max(lifted, rig.pose(0).position.y - start.y); };
  rig.lead(path, 0.5);
  EXPECT_EQ(rig.flags & haptics::kFlagFault, 0u);
  EXPECT_NEAR(rig.pose(0).position.z, start.z + 0.008, 1e-3);
  return lifted;
}

// An edge that stands on a face touches it with its end, whose outward directions include those past the
// end.
TEST(AlignedParts, BlockInSlotOfItsWidthIsNotDrivenOut) {
  const glm::dvec3 wall(0.02, 0.04, 0.1);
  const Solid slot{"slot",
                   {boxAt({0.03, 0.02, 0.1}, {0.0, -0.01, 0.0}), boxAt(wall, {0.025, 0.0, 0.0}),
                    boxAt(wall, {-0.025, 0.0, 0.0})},
                   {}};
  const Solid block{"block", {boxAt({0.03, 0.02, 0.03}, {0.0, 0.0, 0.0})}, {}};
  EXPECT_LT(liftedFrom(slot, block, {0.0, 0.01, 0.0}, {0.0, -0.0005, 0.0}), kLift);
  EXPECT_LT(liftedFrom(slot, block, {0.0, 0.011, 0.0}, {0.0, -0.0015, 0.0}), kLift);
}

TEST(AlignedParts, BlockOnTableBesideAnotherStaysDown) {
  const Solid beside{
      "table", {boxAt({0.4, 0.04, 0.4}, {0.0, -0.04, 0.0}), boxAt({0.06, 0.04, 0.03}, {0.0, 0.0, 0.0})}, {}};
  EXPECT_LT(liftedFrom(beside, boxShape(), {0.061, 0.0, 0.0}, {-0.0015, -0.0003, 0.0}), kLift);
}

/// N, the largest force across the normal that a hand feels which leads a box over a plane of the box's size,
/// by 5 mm along `direction` and back, and holds it `down` m under where it rests.
double sideForceOverPlane(double down, const glm::dvec3& direction) {
  ImplicitShape plane;
  plane.kind = ImplicitShape::Kind::plane;
  plane.size = {0.06, 0.0, 0.03};
  assets::Scene scene = stackOf(boxShape(), {"plane", {plane}, {}});
  scene.parts[0].worldFromPart.position = {0.0, kHalfHeight, 0.0};
  const Pose from = scene.parts[0].worldFromPart;
  MovingRig rig(std::move(scene));
  const auto path = [&](double t) {
    Pose pose = from;
    pose.position.y -= down * std::min(t / 0.1, 1.0);
    pose.position += 0.005 * 0.5 * (1.0 - std::cos(2.0 * kPi * std::max(0.0, t - 0.1))) * direction;
    return pose;
  };
  rig.ownAndGrasp(0, path(0.0));
  double greatest = 0.0;
  rig.each = [&] {
    const glm::dvec3& force = rig.out.hands[0].toHand.force;
    greatest = std::max(greatest, std::hypot(force.x, force.z));
  };
  rig.lead(path, 1.1);
  EXPECT_EQ(rig.flags & haptics::kFlagFault, 0u);
  return greatest;
}

// A known limit (haptics/contact/README.md): without friction no force should act along the plane.
TEST(AlignedParts, ABoxLedOverThePlaneOfItsSizeCatchesAtTheEdgesByNoMoreThanMeasured) {
  for (const double down : {0.0001, 0.0005, 0.001, 0.002}) {
    for (const glm::dvec3& direction : {glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1), glm::dvec3(0.6, 0, 0.8)}) {
      const double force = sideForceOverPlane(down, direction);
      EXPECT_LT(force, 5.0) << down;
      if (!atFullSize()) continue;
      std::printf("%.1f mm down along (%.1f, %.1f): %.2f N\n", 1e3 * down, direction.x, direction.z, force);
    }
  }
}

}  // namespace
}  // namespace tandem::test
