// Distances of implicit shapes by formula: against fine points of the surface, against distances by hand,
// and against what makes contact by them exact, convexity and slope.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/geometry/primitive_distance.h"
#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/contact_patch.h"
#include "haptics/scene/contact_samples.h"
#include "haptics/scene/distance_field.h"
#include "haptics/scene/implicit_mesh.h"
#include "haptics/touch/patch_touch.h"

namespace tandem::test {
namespace {

using assets::ImplicitShape;
using haptics::ContactPatch;
using haptics::Primitive;
using haptics::SurfaceDistance;
using Kind = ImplicitShape::Kind;

struct Named {
  const char* name;
  ImplicitShape shape;
};

ImplicitShape boxOf(const glm::dvec3& size) {
  ImplicitShape s;
  s.kind = Kind::box;
  s.size = size;
  return s;
}

ImplicitShape roundOf(Kind kind, double top, double bottom, double height) {
  ImplicitShape s;
  s.kind = kind;
  s.radiusTop = top;
  s.radiusBottom = bottom;
  s.height = height;
  return s;
}

ImplicitShape planeOf(double x, double z) {
  ImplicitShape s;
  s.kind = Kind::plane;
  s.size = {x, 1.0, z};
  return s;
}

std::vector<Named> allShapes() {
  return {{"box", boxOf({0.02, 0.03, 0.05})},
          {"sphere", roundOf(Kind::sphere, 0.0, 0.013, 0.0)},
          {"capsule", roundOf(Kind::capsule, 0.01, 0.01, 0.04)},
          {"rounded cone", roundOf(Kind::capsule, 0.004, 0.015, 0.03)},
          {"rounded cone, upside down", roundOf(Kind::capsule, 0.015, 0.004, 0.012)},
          {"sphere within a sphere", roundOf(Kind::capsule, 0.003, 0.015, 0.01)},
          {"cylinder", roundOf(Kind::cylinder, 0.01, 0.01, 0.04)},
          {"frustum", roundOf(Kind::cylinder, 0.004, 0.02, 0.02)},
          {"frustum, upside down", roundOf(Kind::cylinder, 0.02, 0.012, 0.03)},
          {"cone", roundOf(Kind::cylinder, 0.0, 0.015, 0.03)},
          {"plane", planeOf(0.05, 0.03)}};
}

/// Without a volume, or without a length at all.
std::vector<Named> thinShapes() {
  return {{"point box", boxOf({0.0, 0.0, 0.0})},
          {"sheet box", boxOf({0.02, 0.0, 0.03})},
          {"point", roundOf(Kind::sphere, 0.0, 0.0, 0.0)},
          {"segment", roundOf(Kind::capsule, 0.0, 0.0, 0.02)},
          {"ball of a capsule", roundOf(Kind::capsule, 0.01, 0.01, 0.0)},
          {"capsule with a tip", roundOf(Kind::capsule, 0.0, 0.01, 0.02)},
          {"sphere that touches the other", roundOf(Kind::capsule, 0.005, 0.015, 0.01)},
          {"disc", roundOf(Kind::cylinder, 0.01, 0.01, 0.0)},
          {"disc of two radii", roundOf(Kind::cylinder, 0.01, 0.004, 0.0)},
          {"straight line", roundOf(Kind::cylinder, 0.0, 0.0, 0.03)},
          {"line plane", planeOf(1e-300, 0.02)}};
}

const Pose kTurned{{0.01, -0.02, 0.005}, fromRotationVector({0.5, -1.1, 0.3})};

assets::Mesh tessellated(const ImplicitShape& shape) { return haptics::meshOfShapes({&shape, 1}, 1.0); }

TEST(PrimitiveDistance, AgreesWithTheTrianglesThatStandForIt) {
  for (Named given : allShapes()) {
    given.shape.partFromShape = kTurned;
    const Primitive shape(given.shape);
    const assets::Mesh mesh = tessellated(given.shape);
    const haptics::TriangleBvh tree(mesh);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> within(-0.05, 0.05);
    // A chord lies 1e-4 of the radius under its arc (implicit_mesh.h), the middle of a patch curved both ways
    // 2e-4.
    const double sag = given.shape.kind == Kind::box || given.shape.kind == Kind::plane ? 1e-12 : 4e-6;
    int inside = 0;
    for (int i = 0; i < 3000; ++i) {
      const glm::dvec3 p = kTurned.position + glm::dvec3(within(random), within(random), within(random));
      const SurfaceDistance read = shape.at(p);
      haptics::MeshPoint nearest;
      ASSERT_TRUE(tree.closestPoint(p, 1.0, nearest));
      EXPECT_NEAR(std::abs(read.distance), nearest.distance, sag) << given.name << " " << i;
      inside += read.distance < 0.0 ? 1 : 0;
    }
    if (given.shape.kind == Kind::plane)
      EXPECT_EQ(inside, 0);
    else
      EXPECT_GT(inside, 3) << given.name;
  }
}

TEST(PrimitiveDistance, IsWhatARulerSays) {
  const Primitive box(boxOf({0.02, 0.04, 0.06}));
  EXPECT_NEAR(box.at({0.013, 0.024, 0.0}).distance, 0.005, 1e-17);
  EXPECT_NEAR(box.at({0.0, 0.0, 0.0}).distance, -0.01, 1e-17);
  EXPECT_NEAR(box.at({0.0, 0.0, 0.028}).distance, -0.002, 1e-17);
  const Primitive sphere(roundOf(Kind::sphere, 0.0, 0.01, 0.0));
  EXPECT_NEAR(sphere.at({0.0, 0.03, 0.04}).distance, 0.04, 1e-17);
  EXPECT_NEAR(sphere.at({0.0, 0.0, 0.0}).distance, -0.01, 1e-17);
  const Primitive capsule(roundOf(Kind::capsule, 0.01, 0.01, 0.04));
  EXPECT_NEAR(capsule.at({0.015, 0.013, 0.0}).distance, 0.005, 1e-17);
  EXPECT_NEAR(capsule.at({0.0, 0.035, 0.0}).distance, 0.005, 1e-17);
  const Primitive cylinder(roundOf(Kind::cylinder, 0.01, 0.01, 0.04));
  EXPECT_NEAR(cylinder.at({0.013, 0.024, 0.0}).distance, 0.005, 1e-17);
  EXPECT_NEAR(cylinder.at({0.0, 0.019, 0.001}).distance, -0.001, 1e-17);
  // A cone of half angle 45 degrees: from the point on the axis half way up the side is h / 2 / sqrt 2 away.
  const Primitive cone(roundOf(Kind::cylinder, 0.0, 0.02, 0.02));
  EXPECT_NEAR(cone.at({0.0, 0.002, 0.0}).distance, -0.008 / std::sqrt(2.0), 1e-17);
  EXPECT_NEAR(cone.at({0.0, 0.012, 0.0}).distance, 0.002, 1e-17);
  // Two spheres of which one holds the other: the larger one.
  const Primitive one(roundOf(Kind::capsule, 0.002, 0.01, 0.004));
  EXPECT_NEAR(one.at({0.02, -0.002, 0.0}).distance, 0.01, 1e-17);
  const Primitive plane(planeOf(0.02, 0.04));
  EXPECT_NEAR(plane.at({0.0, -0.003, 0.0}).distance, 0.003, 1e-17);
  EXPECT_NEAR(plane.at({0.013, 0.004, 0.0}).distance, 0.005, 1e-17);
}

TEST(PrimitiveDistance, SlopesAsItsGradientSays) {
  for (Named given : allShapes()) {
    given.shape.partFromShape = kTurned;
    const Primitive shape(given.shape);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> within(-0.04, 0.04);
    int rough = 0;
    for (int i = 0; i < 2000; ++i) {
      const glm::dvec3 p = kTurned.position + glm::dvec3(within(random), within(random), within(random));
      const SurfaceDistance read = shape.at(p);
      EXPECT_NEAR(glm::length(read.gradient), 1.0, 1e-12) << given.name;
      glm::dvec3 slope(0.0);
      const double h = 1e-8;
      for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 step(0.0);
        step[axis] = h;
        slope[axis] = (shape.at(p + step).distance - shape.at(p - step).distance) / (2.0 * h);
      }
      // Across a ridge of the inside both sides differ: a few points of thousands are within 1e-8 of one.
      rough += glm::length(slope - read.gradient) > 1e-5 ? 1 : 0;
    }
    EXPECT_LE(rough, 2) << given.name;
  }
}

TEST(PrimitiveDistance, IsConvexEverywhere) {
  std::vector<Named> shapes = allShapes();
  for (const Named& thin : thinShapes()) shapes.push_back(thin);
  for (const Named& given : shapes) {
    const Primitive shape(given.shape);
    std::mt19937 random(13);
    std::uniform_real_distribution<double> within(-0.03, 0.03);
    for (int i = 0; i < 4000; ++i) {
      const glm::dvec3 a(within(random), within(random), within(random)),
          b(within(random), within(random), within(random));
      const SurfaceDistance at = shape.at(a), other = shape.at(b);
      EXPECT_LE(shape.at(0.5 * (a + b)).distance, 0.5 * (at.distance + other.distance) + 1e-15) << given.name;
      // The plane that touches it at a lies below it at b.
      EXPECT_GE(other.distance, at.distance + glm::dot(at.gradient, b - a) - 1e-14) << given.name;
    }
  }
}

TEST(PrimitiveDistance, IsANumberWithAUnitGradientWhereverItIsAsked) {
  std::vector<Named> shapes = allShapes();
  for (const Named& thin : thinShapes()) shapes.push_back(thin);
  const double places[] = {0.0,   -0.0,   1e-320, -1e-320, 1e-170, 1e-18, 0.004, 0.005, 0.01,
                           -0.01, 0.0125, 0.015,  -0.015,  0.02,   -0.02, 0.025, 1e3,   -1e150};
  for (const Named& given : shapes) {
    const Primitive shape(given.shape);
    for (const double x : places)
      for (const double y : places)
        for (const double z : places) {
          const SurfaceDistance read = shape.at({x, y, z});
          ASSERT_TRUE(std::isfinite(read.distance)) << given.name << " " << x << " " << y << " " << z;
          ASSERT_NEAR(glm::length(read.gradient), 1.0, 1e-9)
              << given.name << " " << x << " " << y << " " << z;
        }
  }
}

TEST(PrimitiveDistance, EdgesAreWhereTwoFacesMeet) {
  const Primitive box(boxOf({0.02, 0.04, 0.06}));
  haptics::MeshEdge edge;
  ASSERT_TRUE(box.edgeNear({0.011, 0.0205, 0.001}, {}, 0.002, edge));
  EXPECT_NEAR(glm::length(edge.b - edge.a), 0.06, 1e-15);
  EXPECT_NEAR(edge.a.x, 0.01, 1e-15);
  EXPECT_NEAR(edge.a.y, 0.02, 1e-15);
  EXPECT_FALSE(box.edgeNear({0.0, 0.0205, 0.0}, {}, 0.002, edge));
  for (Named given : allShapes()) {
    given.shape.partFromShape = kTurned;
    const Primitive shape(given.shape);
    std::mt19937 random(17);
    std::uniform_real_distribution<double> within(-0.03, 0.03);
    int found = 0;
    for (int i = 0; i < 2000; ++i) {
      const glm::dvec3 p = kTurned.position + glm::dvec3(within(random), within(random), within(random));
      if (!shape.edgeNear(p, {}, 0.01, edge)) continue;
      ++found;
      const glm::dvec3 along = glm::normalize(edge.b - edge.a);
      // As EdgePlane in touching_feature.cpp unrolls it: from the first normal over the outside to the
      // second.
      const glm::dvec3 second =
          std::cos(edge.angle) * edge.normals[0] + std::sin(edge.angle) * glm::cross(along, edge.normals[0]);
      EXPECT_LT(glm::length(second - edge.normals[1]), 1e-9) << given.name;
      const glm::dvec3 middle = 0.5 * (edge.a + edge.b);
      EXPECT_NEAR(shape.at(middle).distance, 0.0, 1e-12) << given.name;
      const glm::dvec3 out = std::cos(0.5 * edge.angle) * edge.normals[0] +
                             std::sin(0.5 * edge.angle) * glm::cross(along, edge.normals[0]);
      EXPECT_NEAR(shape.at(middle + 1e-4 * out).distance, 1e-4, 1e-9) << given.name;
    }
    const bool sharp = given.shape.kind == Kind::box || given.shape.kind == Kind::plane ||
                       given.shape.kind == Kind::cylinder;
    EXPECT_EQ(found > 0, sharp) << given.name;
  }
}

/// The samples' patches together are the surface: every point of it lies on one, and none is off it.
TEST(PrimitiveSamples, PatchesCoverWhatIsRoundAndLieOnIt) {
  for (Named given : allShapes()) {
    if (given.shape.kind == Kind::box || given.shape.kind == Kind::plane) continue;
    given.shape.partFromShape = kTurned;
    const Primitive shape(given.shape);
    const assets::Mesh mesh = tessellated(given.shape);
    const haptics::ContactSamples samples({&given.shape, 1}, mesh, {});
    EXPECT_LT(samples.samples().size(), 520u) << given.name;
    for (const haptics::ContactSample& sample : samples.samples()) {
      EXPECT_NEAR(shape.at(sample.point).distance, 0.0, 1e-12) << given.name;
      if (sample.patch == assets::kNone) continue;
      const ContactPatch& patch = samples.patches()[sample.patch];
      EXPECT_LT(glm::length(patch.sample() - sample.point), 1e-15);
      std::mt19937 random(sample.patch);
      std::normal_distribution<double> any;
      for (int i = 0; i < 8; ++i) {
        const ContactPatch::Place place =
            patch.lowest(glm::normalize(glm::dvec3(any(random), any(random), any(random))), 0.0);
        const glm::dvec3 p = patch.pointAt(place);
        // A zone's patch may go a little beyond the circle in which a sphere ends.
        if (patch.kind != ContactPatch::Kind::cap) {
          EXPECT_NEAR(shape.at(p).distance, 0.0, 1e-12) << given.name;
        }
        EXPECT_LE(shape.at(p).distance, 1e-12) << given.name;
        EXPECT_LE(glm::length(p - sample.point), static_cast<double>(sample.along) * (1.0 + 1e-6));
      }
    }
    // Corners of the triangles lie on the surface; those of the end faces alone need none.
    for (std::size_t v = 0; v < mesh.positions.size(); v += 7) {
      const glm::dvec3& p = mesh.positions[v];
      double least = 1.0;
      for (const haptics::ContactSample& sample : samples.samples()) {
        if (glm::length(p - sample.point) > static_cast<double>(sample.along) + 1e-9) continue;
        if (sample.patch == assets::kNone) {
          least = 0.0;
          continue;
        }
        const ContactPatch& patch = samples.patches()[sample.patch];
        least = std::min(least, glm::length(patch.pointAt(patch.nearestTo(p)) - p));
      }
      haptics::MeshEdge rim;
      if (given.shape.kind == Kind::cylinder && !shape.edgeNear(p, {}, 1e-6, rim)) continue;
      EXPECT_LT(least, 1e-9) << given.name << " " << v;
    }
  }
}

/// The deepest place of a patch against all of its places.
TEST(PrimitiveSamples, TheDeepestPlaceOfAPatchIsFound) {
  const double slack = 1e-9;
  for (const Named& of : allShapes()) {
    if (of.shape.kind == Kind::plane) continue;
    const assets::Mesh mesh = tessellated(of.shape);
    const haptics::ContactSamples samples({&of.shape, 1}, mesh, {});
    for (const Named& target : allShapes()) {
      const Primitive shape(target.shape);
      std::mt19937 random(23);
      std::uniform_real_distribution<double> within(-1.0, 1.0);
      for (int trial = 0; trial < 25; ++trial) {
        if (samples.patches().empty()) break;
        const ContactPatch& own = samples.patches()[random() % samples.patches().size()];
        Pose pose;
        pose.orientation =
            fromRotationVector(3.0 * glm::dvec3(within(random), within(random), within(random)));
        const glm::dvec3 direction =
            glm::normalize(glm::dvec3(within(random), within(random), within(random)));
        // So that the sample lies a little outside of the shape.
        const double reach = 0.08;
        pose.position = direction * reach - pose.orientation * own.sample();
        pose.position -= direction * (shape.at(direction * reach).distance - 1e-3);
        const ContactPatch patch = own.moved(pose);
        const haptics::PatchTouch found = haptics::deepestIn(shape, patch, slack);
        double least = 1.0;
        for (int i = 0; i <= 60; ++i)
          for (int k = 0; k <= (patch.kind == ContactPatch::Kind::cap ? 60 : 0); ++k) {
            ContactPatch::Place place{patch.out, 0.0};
            const double share = i / 30.0 - 1.0;
            if (patch.kind == ContactPatch::Kind::straight) place.t = share * patch.along;
            if (patch.kind == ContactPatch::Kind::rim)
              place.out = std::cos(share * patch.angle) * patch.out +
                          std::sin(share * patch.angle) * glm::cross(patch.axis, patch.out);
            if (patch.kind == ContactPatch::Kind::cap) {
              const glm::dvec3 a = glm::normalize(glm::cross(patch.out, glm::dvec3(0.3, 0.5, 0.81))),
                               b = glm::cross(patch.out, a);
              const double angle = patch.angle * i / 60.0, about = 2.0 * 3.14159265358979 * k / 60.0;
              place.out =
                  std::cos(angle) * patch.out + std::sin(angle) * (std::cos(about) * a + std::sin(about) * b);
            }
            if (patch.kind == ContactPatch::Kind::side) {
              for (int t = 0; t <= 60; ++t) {
                const double angle = share * patch.angle;
                place.t = (t / 30.0 - 1.0) * patch.along;
                place.out = std::cos(angle) * patch.out + std::sin(angle) * glm::cross(patch.axis, patch.out);
                least = std::min(least, shape.at(patch.pointAt(place)).distance);
              }
              continue;
            }
            least = std::min(least, shape.at(patch.pointAt(place)).distance);
          }
        // Where the deepest place of the whole sphere or side lies on another patch, any place will do: its
        // plane holds all the same. Else nothing of the patch is deeper.
        const glm::dvec3 up = found.read.gradient;
        std::array<glm::dvec3, 2> normals;
        const int count = patch.normalsAt(found.place, normals);
        const bool its = count == 0 || count == 2 || glm::dot(normals[0], up) < -1.0 + 1e-9;
        if (its) {
          EXPECT_LE(found.read.distance, least + 5.0 * slack) << of.name << " on " << target.name;
        }
      }
    }
  }
}

TEST(PrimitiveField, AnswersWithTheErrorOfItsFloats) {
  for (Named given : allShapes()) {
    given.shape.partFromShape = kTurned;
    const assets::Mesh mesh = tessellated(given.shape);
    const haptics::DistanceField field({&given.shape, 1}, mesh, 1e-6);
    const Primitive shape(given.shape);
    EXPECT_EQ(field.cells(), 0u);
    EXPECT_EQ(field.solid(), given.shape.kind != Kind::plane);
    EXPECT_LT(field.memory(), 1000u);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> within(-0.1, 0.1);
    for (int i = 0; i < 1000; ++i) {
      const glm::dvec3 p = field.origin() + glm::dvec3(within(random), within(random), within(random));
      const haptics::DistanceField::Reading read = field.read(glm::vec3(p - field.origin()));
      EXPECT_LE(std::abs(static_cast<double>(read.distance) - shape.at(p).distance),
                static_cast<double>(read.error));
      EXPECT_LT(read.error, 1e-7f);
    }
  }
}

TEST(PrimitiveField, OfSeveralShapesIsTheNearestAndNeverTooDeep) {
  std::vector<ImplicitShape> shapes = {boxOf({0.02, 0.02, 0.02}), roundOf(Kind::sphere, 0.0, 0.01, 0.0)};
  shapes[1].partFromShape.position = {0.01, 0.0, 0.0};
  const assets::Mesh mesh = haptics::meshOfShapes(shapes, 1.0);
  const haptics::DistanceField field(shapes, mesh, 1e-6);
  const auto at = [&](const glm::dvec3& p) {
    return static_cast<double>(field.read(glm::vec3(p - field.origin())).distance);
  };
  EXPECT_NEAR(at({0.03, 0.0, 0.0}), 0.01, 1e-8);
  EXPECT_NEAR(at({-0.03, 0.0, 0.0}), 0.02, 1e-8);
  // In both: as deep as in the one that holds it deeper, and no deeper than in both together.
  EXPECT_NEAR(at({0.009, 0.0, 0.0}), -0.009, 1e-8);
  EXPECT_NEAR(at({0.005, 0.0, 0.0}), -0.005, 1e-8);
}

}  // namespace
}  // namespace tandem::test
