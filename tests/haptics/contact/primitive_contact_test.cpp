// Parts in the hand that are known by formula: where they rest, by geometry and not by the code's own
// distances. At scales 1e-3, 1 and 20 of one motion: stiffness and mass are the same, forces grow with the
// lengths.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/scene/contact_scene_data.h"
#include "tests/haptics/contact/moving_rig.h"
#include "tests/haptics/contact/part_contact_case.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using assets::ImplicitShape;
using Kind = ImplicitShape::Kind;

const glm::dquat kNotTurned(1.0, 0.0, 0.0, 0.0);
constexpr double kScales[] = {1e-3, 1.0, 20.0};
// Of a part of 20 mm: how deep it may be at any time, and how far off it may rest, m.
constexpr double kDeep = 1e-6, kOff = 0.1e-6;

/// A part of shapes, or of a mesh where there are none; movable with a mass.
struct Given {
  std::vector<ImplicitShape> shapes;
  assets::TriangleSoup soup{};
  Pose pose{};
  double mass = 0.0;
  double inertia = 0.0;  // kg m^2, about each axis
  double friction = 0.0;
  double tolerance = 0.0;  // m, as the file states it
};

ImplicitShape shapeAt(ImplicitShape shape, const Pose& pose) {
  shape.partFromShape = pose;
  return shape;
}
ImplicitShape ball(double radius) {
  ImplicitShape s;
  s.kind = Kind::sphere;
  s.radiusBottom = radius;
  return s;
}
ImplicitShape box(const glm::dvec3& size) {
  ImplicitShape s;
  s.kind = Kind::box;
  s.size = size;
  return s;
}
/// Along Y.
ImplicitShape rod(Kind kind, double radius, double height) {
  ImplicitShape s;
  s.kind = kind;
  s.radiusTop = s.radiusBottom = radius;
  s.height = height;
  return s;
}

assets::Scene sceneOf(const std::vector<Given>& parts) {
  assets::Scene scene;
  for (const Given& given : parts) {
    assets::Material material;
    material.staticFriction = material.dynamicFriction = given.friction;
    scene.materials.push_back(material);
    const auto index = static_cast<std::uint16_t>(scene.materials.size() - 1);
    assets::Part part;
    part.name = "part" + std::to_string(index);
    part.worldFromPart = given.pose;
    part.contactTolerance = given.tolerance;
    part.shapes = given.shapes;
    for (ImplicitShape& shape : part.shapes) shape.material = index;
    if (part.shapes.empty()) {
      part.mesh = static_cast<std::uint32_t>(scene.meshes.size());
      scene.meshes.push_back(meshOf(given.soup));
      std::fill(scene.meshes.back().triangleMaterial.begin(), scene.meshes.back().triangleMaterial.end(),
                index);
    }
    part.movable = given.mass > 0.0;
    part.massProperties.mass = given.mass;
    part.massProperties.inertia = glm::dmat3(given.inertia);
    scene.parts.push_back(part);
  }
  scene.bounds.min = glm::dvec3(-0.1);
  scene.bounds.max = glm::dvec3(0.1);
  return scene;
}

/// The result of leading part 0 along a path by hand.
struct Met {
  double deepest = 0.0;  // m
  double last = 0.0;     // m, the gap at the end
  double buzz = 0.0;     // N, the 99 % quantile of changes of force a tick in the last third
  double press = 0.0;    // N, at the end
  Pose pose;             // of the part, at the end
  std::uint32_t flags = 0;
};

/// `path`: of the part's frame, from its pose at 0 to the end at 1, taken in `duration` s and held for 0.2 s
/// more. `gap`: m between the part at a pose and what is around it.
Met lead(assets::Scene scene, double scale, const std::function<Pose(double)>& path, double duration,
         const std::function<double(const Pose&)>& gap) {
  MovingRig rig(std::move(scene));
  // Torques grow with lengths: so that all scales are one motion.
  rig.parameters.graspRotStiffness *= scale * scale;
  rig.parameters.graspRotDamping *= scale * scale;
  rig.ownAndGrasp(0, path(0.0));
  Met met;
  std::vector<double> steps;
  glm::dvec3 before(0.0);
  int ticks = 0;
  const int total = static_cast<int>(1000.0 * (duration + 0.2));
  rig.each = [&] {
    met.deepest = std::max(met.deepest, -gap(rig.pose(0)));
    if (++ticks > 2 * total / 3) steps.push_back(glm::length(rig.out.hands[0].toHand.force - before));
    before = rig.out.hands[0].toHand.force;
  };
  rig.lead([&](double t) { return path(t / duration); }, duration);
  rig.tick(200);
  met.last = gap(rig.pose(0));
  met.buzz = quantile(steps, 0.99);
  met.press = glm::length(before);
  met.pose = rig.pose(0);
  met.flags = rig.flags;
  return met;
}

void expectExact(const Met& met, double scale, const std::string& what, double press = 0.1) {
  if (atFullSize())
    std::printf("%-40s scale %6.3f deepest %8.4f um of 20 mm, at the end %8.4f, buzz %.5f N, press %.3f N\n",
                what.c_str(), scale, 1e6 * met.deepest / scale, 1e6 * met.last / scale, met.buzz / scale,
                met.press / scale);
  EXPECT_LT(met.deepest, kDeep * scale) << what << " at " << scale;
  EXPECT_LT(std::abs(met.last), kOff * scale) << what << " at " << scale;
  EXPECT_LT(met.buzz, 0.05 * scale) << what << " at " << scale;
  EXPECT_GT(met.press, press * scale) << what << " at " << scale;  // it was pressed on what it rests on
  EXPECT_EQ(met.flags & haptics::kFlagFault, 0u) << what << " at " << scale;
}

/// Down along -z by `down` and aside by `aside`, without rotation.
std::function<Pose(double)> straight(const Pose& from, const glm::dvec3& by) {
  return [from, by](double t) {
    return Pose{from.position + std::clamp(t, 0.0, 1.0) * by, from.orientation};
  };
}

/// Distance of a point from a box around the origin: as a ruler lies, outside only.
double fromBox(const glm::dvec3& p, const glm::dvec3& size) {
  return glm::length(glm::max(glm::abs(p) - 0.5 * size, glm::dvec3(0.0)));
}

/// Height of the lowest point of a cylinder with its axis along the pose's Y.
double lowestOfCylinder(const Pose& pose, double radius, double height) {
  const glm::dvec3 a = pose.orientation * glm::dvec3(0.0, 1.0, 0.0);
  return pose.position.z - 0.5 * height * std::abs(a.z) - radius * std::sqrt(std::max(0.0, 1.0 - a.z * a.z));
}

Given held(std::vector<ImplicitShape> shapes, const Pose& pose, double scale) {
  return {std::move(shapes), {}, pose, 0.05, 5e-6 * scale * scale, 0.0};
}

constexpr double kRadius = 0.01;

TEST(PrimitiveContact, ABallRestsOnAPlateAndIsLedAcrossIt) {
  for (const double s : kScales) {
    const double r = kRadius * s;
    const Pose start{{-0.005 * s, 0.002 * s, r + 0.0005 * s}, fromRotationVector({0.3, 0.2, 0.1})};
    const assets::Scene scene =
        sceneOf({held({ball(r)}, start, s),
                 {{box(glm::dvec3(0.06, 0.06, 0.02) * s)}, {}, {{0, 0, -0.01 * s}, kNotTurned}}});
    const Met met = lead(scene, s, straight(start, glm::dvec3(0.012, 0.003, -0.0015) * s), 0.4,
                         [r](const Pose& p) { return p.position.z - r; });
    expectExact(met, s, "ball on plate");
  }
}

TEST(PrimitiveContact, ABallRestsOnAPlane) {
  for (const double s : kScales) {
    const double r = kRadius * s;
    ImplicitShape plane;
    plane.kind = Kind::plane;
    plane.size = {0.0, 1.0, 0.0};
    // Its normal is +Y; seen from below it is a surface as well.
    for (const double side : {1.0, -1.0}) {
      const Pose start{{0.0, side * (r + 0.0005 * s), 0.0}, fromRotationVector({0.3, 0.2, 0.1})};
      const Met met = lead(sceneOf({held({ball(r)}, start, s), {{plane}, {}, {}}}), s,
                           straight(start, glm::dvec3(0.012, -0.0015 * side, 0.003) * s), 0.4,
                           [r, side](const Pose& p) { return side * p.position.y - r; });
      expectExact(met, s, "ball on plane");
    }
  }
}

TEST(PrimitiveContact, ABallSlidesOffABall) {
  for (const double s : kScales) {
    const double r = kRadius * s, other = 0.015 * s;
    const Pose start{{0.001 * s, 0.0, r + other + 0.0005 * s}, kNotTurned};
    const Met met = lead(sceneOf({held({ball(r)}, start, s), {{ball(other)}, {}, {}}}), s,
                         straight(start, glm::dvec3(0.006, 0.003, -0.003) * s), 0.4,
                         [=](const Pose& p) { return glm::length(p.position) - r - other; });
    expectExact(met, s, "ball on ball");
  }
}

TEST(PrimitiveContact, ABallRestsInACornerOfThreeBoxes) {
  for (const double s : kScales) {
    const double r = kRadius * s;
    std::vector<ImplicitShape> walls;
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 size(0.06 * s), at(0.02 * s);
      size[axis] = 0.01 * s;
      at[axis] = -0.005 * s;
      walls.push_back(shapeAt(box(size), {at, kNotTurned}));
    }
    const Pose start{glm::dvec3(r + 0.0005 * s), fromRotationVector({0.3, 0.2, 0.1})};
    const Met met = lead(sceneOf({held({ball(r)}, start, s), {walls, {}, {}}}), s,
                         straight(start, glm::dvec3(-0.0013, -0.0015, -0.0017) * s), 0.3, [r](const Pose& p) {
                           return std::min({p.position.x, p.position.y, p.position.z}) - r;
                         });
    expectExact(met, s, "ball in a corner");
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(met.pose.position[axis], r, kOff * s);
  }
}

TEST(PrimitiveContact, ABallIsLedOverAnEdge) {
  for (const double s : kScales) {
    const double r = kRadius * s;
    const glm::dvec3 size = glm::dvec3(0.04, 0.06, 0.02) * s, at = glm::dvec3(-0.02, 0.0, -0.01) * s;
    const Pose start{{-0.006 * s, 0.001 * s, r + 0.0005 * s}, kNotTurned};
    const auto gap = [=](const Pose& p) { return fromBox(p.position - at, size) - r; };
    const Met met = lead(sceneOf({held({ball(r)}, start, s), {{box(size)}, {}, {at, kNotTurned}}}), s,
                         straight(start, glm::dvec3(0.012, 0.002, -0.003) * s), 0.4, gap);
    expectExact(met, s, "ball on an edge");
    EXPECT_GT(met.pose.position.x, 0.0);
  }
}

TEST(PrimitiveContact, ABallRestsInAGrooveOfTriangles) {
  for (const double half : {0.6, 1.3})
    for (const double s : kScales) {
      const double r = kRadius * s, depth = std::tan(0.5 * kPi - half) * 0.03 * s;
      Given groove;
      groove.soup = vGrooveSoup(depth, half, 0.01 * s, 0.06 * s);
      const double height = r / std::sin(half);
      const Pose start{{0.0004 * s, 0.001 * s, height + 0.0008 * s}, fromRotationVector({0.3, 0.2, 0.1})};
      const auto gap = [=](const Pose& p) {
        // Both walls go up from the line x = z = 0, `half` from the vertical.
        return -std::abs(p.position.x) * std::cos(half) + p.position.z * std::sin(half) - r;
      };
      const Met met = lead(sceneOf({held({ball(r)}, start, s), groove}), s,
                           straight(start, glm::dvec3(-0.0003, 0.004, -0.002) * s), 0.4, gap);
      expectExact(met, s, "ball in a groove of " + std::to_string(half));
    }
}

/// How far a circle about p, across `axis`, may still grow before it meets the sides of the bore's polygon,
/// m. A ball is a circle across any axis: zero.
double roomInBore(const glm::dvec3& p, const glm::dvec3& axis, double radius, double boreRadius,
                  int segments) {
  double least = 1.0;
  for (int i = 0; i < segments; ++i) {
    const double a = 2.0 * kPi * (i + 0.5) / segments;
    const glm::dvec3 out(std::cos(a), std::sin(a), 0.0);
    const double leans = glm::dot(out, axis), reach = radius * std::sqrt(1.0 - leans * leans);
    least = std::min(least, boreRadius - reach - glm::dot(out, p));
  }
  return least;
}

TEST(PrimitiveContact, ABallGoesIntoABoreOfTrianglesTwentyMicronsWider) {
  for (const double s : kScales) {
    const double r = kRadius * s, bore = r + 0.01e-3 * s;
    Given block;
    BoredBlock given{bore, 0.045 * s, 0.06 * s, 0.045 * s, 0.001 * s, Fit::around, {160, 8}};
    block.soup = boredBlockSoup(given);
    block.tolerance = 1.25e-6 * s;  // an eighth of the radial clearance, for the fit is not seen at rest
    const Pose start{{0.0003 * s, -0.0002 * s, r + 0.001 * s}, kNotTurned};
    const auto gap = [=](const Pose& p) {
      return p.position.z < -0.0015 * s ? roomInBore(p.position, glm::dvec3(0.0), r, bore, 160) : 0.0;
    };
    const Met met = lead(sceneOf({held({ball(r)}, start, s), block}), s,
                         straight(start, glm::dvec3(0.0, 0.0, -0.03) * s), 1.0, gap);
    if (atFullSize())
      std::printf("ball in a bore: scale %6.3f deepest %.4f um, z %.3f mm\n", s, 1e6 * met.deepest / s,
                  1e3 * met.pose.position.z / s);
    EXPECT_LT(met.deepest, kDeep * s) << s;
    EXPECT_NEAR(met.pose.position.z, start.position.z - 0.03 * s, 0.0005 * s) << s;
    EXPECT_LT(met.buzz, 0.05 * s) << s;
  }
}

TEST(PrimitiveContact, APinGoesIntoABoreOfTrianglesTwentyMicronsWider) {
  for (const double s : kScales) {
    const double r = kRadius * s, bore = r + 0.01e-3 * s, height = 0.04 * s;
    Given block;
    BoredBlock given{bore, 0.045 * s, 0.06 * s, 0.045 * s, 0.001 * s, Fit::around, {160, 8}};
    block.soup = boredBlockSoup(given);
    block.tolerance = 1.25e-6 * s;  // an eighth of the radial clearance, for the fit is not seen at rest
    // Its axis, Y, down the bore: somewhat askew and beside it.
    const glm::dquat upright = fromRotationVector({0.5 * kPi, 0.0, 0.0});
    const Pose start{{0.0003 * s, -0.0002 * s, 0.5 * height + 0.001 * s},
                     fromRotationVector({0.01, 0.015, 0.0}) * upright};
    const auto gap = [=](const Pose& p) {
      // Its ends, as far as they are in the bore below its chamfer.
      double least = 0.0;
      const glm::dvec3 a = p.orientation * glm::dvec3(0.0, 1.0, 0.0);
      for (const double end : {-0.5, 0.5}) {
        const glm::dvec3 c = p.position + end * height * a;
        if (c.z < -0.0015 * s) least = std::min(least, roomInBore(c, a, r, bore, 160));
      }
      return least;
    };
    const Met met = lead(sceneOf({held({rod(Kind::cylinder, r, height)}, start, s), block}), s,
                         straight(start, glm::dvec3(0.0, 0.0, -0.035) * s), 1.6, gap);
    if (atFullSize())
      std::printf("pin in a bore: scale %6.3f deepest %.4f um, z %.3f mm\n", s, 1e6 * met.deepest / s,
                  1e3 * met.pose.position.z / s);
    EXPECT_LT(met.deepest, kDeep * s) << s;
    EXPECT_NEAR(met.pose.position.z, start.position.z - 0.035 * s, 0.0005 * s) << s;
    EXPECT_LT(met.buzz, 0.05 * s) << s;
  }
}

/// A cylinder and its chamfer, a frustum: the faces on which they meet are seen by nobody, and hold nothing
/// up.
TEST(PrimitiveContact, APinOfTwoShapesGoesIntoABoreWithASharpRim) {
  const double r = kRadius, bore = r + 0.01e-3, height = 0.039, chamfer = 0.001;
  Given block;
  block.soup = boredBlockSoup({bore, 0.045, 0.06, 0.045, 0.0, Fit::around, {160, 8}});
  block.tolerance = 1.25e-6;
  const Pose body{{0.0, 0.5 * height + chamfer, 0.0}, kNotTurned};
  ImplicitShape tip = rod(Kind::cylinder, r, chamfer);
  tip.radiusBottom = r - chamfer;
  const std::vector<ImplicitShape> shapes = {shapeAt(rod(Kind::cylinder, r, height), body),
                                             shapeAt(tip, {{0.0, 0.5 * chamfer, 0.0}, kNotTurned})};
  const glm::dquat upright = fromRotationVector({0.5 * kPi, 0.0, 0.0});
  const Pose start{{0.0004, -0.0003, 0.001}, fromRotationVector({0.015, 0.02, 0.0}) * upright};
  const Met met = lead(sceneOf({held(shapes, start, 1.0), block}), 1.0,
                       straight(start, glm::dvec3(0.0, 0.0, -0.035)), 1.6, [](const Pose&) { return 0.0; });
  EXPECT_NEAR(met.pose.position.z, start.position.z - 0.035, 0.0005);
  EXPECT_LT(met.buzz, 0.05);
}

/// Turned about its own axis as it goes: as it would roll.
TEST(PrimitiveContact, ACylinderRollsOnAPlate) {
  for (const double s : kScales) {
    const double r = kRadius * s, height = 0.03 * s;
    const Pose start{{-0.005 * s, 0.0, r + 0.0005 * s}, kNotTurned};
    const auto path = [=](double t) {
      const double u = std::clamp(t, 0.0, 1.0), x = 0.012 * s * u;
      return Pose{start.position + glm::dvec3(x, 0.0, -0.0015 * s * std::min(1.0, 4.0 * u)),
                  fromRotationVector({0.0, x / r, 0.0})};
    };
    const assets::Scene scene =
        sceneOf({held({rod(Kind::cylinder, r, height)}, start, s),
                 {{box(glm::dvec3(0.06, 0.06, 0.02) * s)}, {}, {{0, 0, -0.01 * s}, kNotTurned}}});
    const Met met = lead(scene, s, path, 0.6, [=](const Pose& p) { return lowestOfCylinder(p, r, height); });
    expectExact(met, s, "cylinder on plate");
  }
}

TEST(PrimitiveContact, ACylinderRollsOnACrossedCylinder) {
  for (const double s : kScales) {
    const double r = kRadius * s, other = 0.006 * s;
    const Pose start{{-0.002 * s, 0.001 * s, r + other + 0.0005 * s}, kNotTurned};
    const glm::dquat along = fromRotationVector({0.0, 0.0, 0.5 * kPi});  // its Y lies along -X
    const auto path = [=](double t) {
      const double u = std::clamp(t, 0.0, 1.0), x = 0.006 * s * u;
      return Pose{start.position + glm::dvec3(x, 0.002 * s * u, -0.0015 * s * std::min(1.0, 4.0 * u)),
                  fromRotationVector({0.0, x / r, 0.0})};
    };
    const auto gap = [=](const Pose& p) {
      const glm::dvec3 a = p.orientation * glm::dvec3(0.0, 1.0, 0.0), b(1.0, 0.0, 0.0);
      const glm::dvec3 n = glm::normalize(glm::cross(a, b));
      return std::abs(glm::dot(n, p.position)) - r - other;
    };
    const Met met = lead(sceneOf({held({rod(Kind::cylinder, r, 0.03 * s)}, start, s),
                                  {{rod(Kind::cylinder, other, 0.05 * s)}, {}, {glm::dvec3(0.0), along}}}),
                         s, path, 0.6, gap);
    expectExact(met, s, "crossed cylinders");
  }
}

/// Least distance of two segments a + t u and b + v w, 0..1 each: by a search that knows nothing of geometry.
double betweenSegments(const glm::dvec3& a, const glm::dvec3& u, const glm::dvec3& b, const glm::dvec3& w) {
  const auto at = [&](double t) {
    const glm::dvec3 p = a + t * u;
    const double v = std::clamp(glm::dot(p - b, w) / glm::dot(w, w), 0.0, 1.0);
    return glm::length(p - b - v * w);
  };
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 100; ++i) {
    const double c = low + (high - low) / 3.0, d = high - (high - low) / 3.0;
    (at(c) < at(d) ? high : low) = at(c) < at(d) ? d : c;
  }
  return at(0.5 * (low + high));
}

TEST(PrimitiveContact, ACapsuleRestsAcrossAnEdge) {
  for (const double s : kScales) {
    const double r = 0.006 * s;
    // Over the upper edge of a box, along Y at x = z = 0.
    const glm::dvec3 size = glm::dvec3(0.04, 0.06, 0.02) * s, at = glm::dvec3(-0.02, 0.0, -0.01) * s;
    const glm::dquat lying =
        fromRotationVector({0.0, 0.6, 0.0}) * fromRotationVector({0.0, 0.0, 0.5 * kPi - 0.2});
    const glm::dvec3 axis = lying * glm::dvec3(0.0, 1.0, 0.0);
    const glm::dvec3 up = glm::normalize(glm::cross(axis, glm::dvec3(0.0, 1.0, 0.0)));
    const glm::dvec3 above = up.z < 0.0 ? -up : up;
    const Pose start{above * (r + 0.0005 * s), lying};
    const auto gap = [=](const Pose& p) {
      const glm::dvec3 a = p.orientation * glm::dvec3(0.0, 0.03 * s, 0.0);
      return betweenSegments(p.position - 0.5 * a, a, {0.0, -0.03 * s, 0.0}, {0.0, 0.06 * s, 0.0}) - r;
    };
    const Met met = lead(
        sceneOf({held({rod(Kind::capsule, r, 0.03 * s)}, start, s), {{box(size)}, {}, {at, kNotTurned}}}), s,
        straight(start, -above * 0.0015 * s + glm::dvec3(0.0, 0.003 * s, 0.0)), 0.4, gap);
    expectExact(met, s, "capsule on an edge");
  }
}

TEST(PrimitiveContact, ABoxRestsOnASphere) {
  for (const double s : kScales) {
    const double r = 0.015 * s;
    const glm::dvec3 size = glm::dvec3(0.03, 0.02, 0.02) * s;
    for (const glm::dvec3& lean : {glm::dvec3(0.0), glm::dvec3(0.5, 0.0, 0.0), glm::dvec3(0.7, 0.6, 0.0)}) {
      const glm::dquat orientation = fromRotationVector(lean);
      // Down along -z from where it is just above.
      double z = 0.05 * s;
      const auto gap = [=](const Pose& p) {
        return fromBox(glm::conjugate(p.orientation) * -p.position, size) - r;
      };
      while (gap({{0.0, 0.001 * s, z}, orientation}) > 0.0006 * s) z -= 0.0001 * s;
      const Pose start{{0.0, 0.001 * s, z}, orientation};
      const Met met = lead(sceneOf({held({box(size)}, start, s), {{ball(r)}, {}, {}}}), s,
                           straight(start, glm::dvec3(0.001, 0.001, -0.002) * s), 0.4, gap);
      expectExact(met, s, "box on sphere");
    }
  }
}

/// Height of the lowest corner of a box.
double lowestOfBox(const Pose& p, const glm::dvec3& size) {
  double least = 1e300;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner((i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5, (i & 4) != 0 ? 0.5 : -0.5);
    least = std::min(least, transformPoint(p, corner * size).z);
  }
  return least;
}

TEST(PrimitiveContact, ABoxRestsOnABox) {
  for (const double s : kScales) {
    const glm::dvec3 size = glm::dvec3(0.02, 0.015, 0.01) * s;
    const Pose start{{0.0, 0.0, 0.0056 * s}, fromRotationVector({0.0, 0.0, 0.4})};
    const assets::Scene scene =
        sceneOf({held({box(size)}, start, s),
                 {{box(glm::dvec3(0.06, 0.06, 0.02) * s)}, {}, {{0, 0, -0.01 * s}, kNotTurned}}});
    const Met met = lead(scene, s, straight(start, glm::dvec3(0.006, 0.002, -0.0015) * s), 0.4,
                         [=](const Pose& p) { return lowestOfBox(p, size); });
    expectExact(met, s, "box on box");
  }
}

TEST(PrimitiveContact, ABoxRestsOnABoxOfTriangles) {
  for (const double s : kScales) {
    const glm::dvec3 size = glm::dvec3(0.02, 0.015, 0.01) * s;
    // Within the plate, and over its edge.
    for (const double beside : {0.0, 0.027}) {
      const Pose start{{beside * s, 0.0, 0.0056 * s}, fromRotationVector({0.0, 0.0, 0.4})};
      Given plate{{}, boxSoup(glm::dvec3(0.06, 0.06, 0.02) * s), {{0, 0, -0.01 * s}, kNotTurned}};
      const assets::Scene scene = sceneOf({held({box(size)}, start, s), plate});
      const Met met = lead(scene, s, straight(start, glm::dvec3(0.001, 0.002, -0.0015) * s), 0.4,
                           [=](const Pose& p) { return lowestOfBox(p, size); });
      expectExact(met, s, "box on box of triangles");
    }
  }
}

TEST(PrimitiveContact, ACubeOfTrianglesRestsOnAPlaneAndComesOffAgain) {
  for (const double s : kScales) {
    const glm::dvec3 size = glm::dvec3(0.02) * s;
    ImplicitShape plane;
    plane.kind = Kind::plane;
    plane.size = glm::dvec3(0.1, 1.0, 0.1) * s;
    const glm::dquat facing = fromRotationVector({0.5 * kPi, 0.0, 0.0});  // its normal along +z
    const Pose start{{0.0, 0.0, 0.0106 * s}, fromRotationVector({0.0, 0.0, 0.4})};
    Given cube = held({}, start, s);
    cube.soup = boxSoup(size);
    const assets::Scene scene = sceneOf({cube, {{plane}, {}, {glm::dvec3(0.0), facing}}});
    const auto gap = [=](const Pose& p) { return lowestOfBox(p, size); };
    expectExact(lead(scene, s, straight(start, glm::dvec3(0.006, 0.002, -0.0015) * s), 0.4, gap), s,
                "cube on plane");
    // Down and up again: nothing holds it back.
    const auto path = [=](double t) {
      return Pose{
          start.position + glm::dvec3(0.0, 0.0, 0.0015 * s * (t < 0.5 ? -2.0 * t : -1.0 + 4.0 * (t - 0.5))),
          start.orientation};
    };
    const Met met = lead(scene, s, path, 0.8, gap);
    EXPECT_NEAR(met.pose.position.z, path(1.0).position.z, 10e-6 * s) << s;
    EXPECT_LT(met.deepest, kDeep * s) << s;
  }
}

/// What the bounds above say of the same ball as triangles, as fine as shapes are where they are drawn.
TEST(PrimitiveContact, ABallOfTrianglesMissesTheBound) {
  const double r = kRadius;
  const Pose start{{-0.005, 0.002, r + 0.0005}, fromRotationVector({0.3, 0.2, 0.1})};
  Given mesh = held({}, start, 1.0);
  mesh.soup = sphereSoup(r, 112);
  const assets::Scene scene = sceneOf({mesh, {{box({0.06, 0.06, 0.02})}, {}, {{0, 0, -0.01}, kNotTurned}}});
  const Met met = lead(scene, 1.0, straight(start, {0.012, 0.003, -0.0015}), 0.4,
                       [r](const Pose& p) { return p.position.z - r; });
  if (atFullSize())
    std::printf("ball of triangles: %.3f um deep, %.3f um off\n", 1e6 * met.deepest, 1e6 * met.last);
  EXPECT_GT(std::max(met.deepest / kDeep, std::abs(met.last) / kOff), 1.0);
}

/// Two slabs of one part, of which one is rough: the friction is that of the shape under the foot.
TEST(PrimitiveContact, EachShapeHasItsOwnMaterial) {
  const Pose start{{-0.012, 0.0, 0.0055}, kNotTurned};
  const ImplicitShape slab = box({0.04, 0.04, 0.01});
  assets::Scene scene = sceneOf(
      {held({box(glm::dvec3(0.01))}, start, 1.0),
       {{shapeAt(slab, {{-0.02, 0.0, -0.005}, kNotTurned}), shapeAt(slab, {{0.02, 0.0, -0.005}, kNotTurned})},
        {},
        {}}});
  scene.materials.emplace_back();
  scene.materials.back().staticFriction = scene.materials.back().dynamicFriction = 0.6;
  scene.parts[1].shapes[1].material = static_cast<std::uint16_t>(scene.materials.size() - 1);
  MovingRig rig(scene);
  rig.ownAndGrasp(0, start);
  const auto to = [&](const glm::dvec3& by) { return Pose{start.position + by, kNotTurned}; };
  rig.lead([&](double t) { return to({0.004 * t / 0.2, 0.0, -0.0015 * t / 0.2}); }, 0.2);
  EXPECT_NEAR(rig.out.hands[0].toHand.force.z, 1.0, 0.1);
  EXPECT_LT(std::abs(rig.out.hands[0].toHand.force.x), 0.1);  // damping and inertia alone
  rig.lead([&](double t) { return to({0.004 + 0.02 * t / 1.0, 0.0, -0.0015}); }, 1.0);
  // Half of 0.6, for the foot has none.
  EXPECT_NEAR(rig.out.hands[0].toHand.force.x, -0.3 * rig.out.hands[0].toHand.force.z, 0.05);
}

TEST(PrimitiveContact, NeedsNothingBaked) {
  std::vector<Given> parts;
  for (int i = 0; i < 40; ++i) {
    const Pose pose{{0.05 * i, 0.0, 0.0}, kNotTurned};
    parts.push_back(i % 2 == 0 ? held({rod(Kind::capsule, 0.01, 0.02)}, pose, 1.0)
                               : Given{{box({0.02, 0.02, 0.02})}, {}, pose});
  }
  const assets::Scene scene = sceneOf(parts);
  haptics::ContactScene contact(scene, 1);
  haptics::ModelOptions options;
  options.onlyCached = true;  // there is no cache
  ASSERT_TRUE(contact.modelParts(options));
  for (const haptics::Collider& collider : contact.data().colliders) {
    ASSERT_NE(collider.model, nullptr);
    EXPECT_TRUE(collider.model->byFormula());
    EXPECT_EQ(collider.model->field.cells(), 0u);
  }
}

}  // namespace
}  // namespace tandem::test
