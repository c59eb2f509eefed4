// The cells that a field needs are known before it is made: from how the surface curves, and what may be
// wrong.

#include "haptics/scene/field_resolution.h"

#include <gtest/gtest.h>

#include <cmath>

#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/distance_field.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

using haptics::cellForCurves;

constexpr double kRadius = 0.010, kTolerance = 10e-6;

/// A disc as thick as its radius, of sides far narrower than its cells.
assets::Mesh disc(double scale = 1.0) {
  return meshOf(pegSoup({scale * kRadius, scale * kRadius, 0.0, {1024, 2}}));
}

/// Of a ball of this radius about a cell, a cylinder bulges r^2 / 2R out of its tangent plane, half of that
/// to either side of the best one: r^2 / 4R.
double cellOfCylinder(double radius, double tolerance) {
  return 2.0 / std::sqrt(3.0) * std::sqrt(4.0 * tolerance * radius);
}

TEST(FieldResolution, FollowsFromTheRadiusOfACylinder) {
  const double expected = cellOfCylinder(kRadius, kTolerance);
  EXPECT_NEAR(cellForCurves(disc(), kTolerance), expected, 1e-3 * expected);
  EXPECT_NEAR(cellForCurves(disc(), 0.25 * kTolerance), 0.5 * expected, 1e-3 * expected);
  EXPECT_NEAR(cellForCurves(disc(20.0), 20.0 * kTolerance), 20.0 * expected, 2e-2 * expected);
}

TEST(FieldResolution, FlatFacesNeedNoCells) {
  EXPECT_GT(cellForCurves(meshOf(boxSoup(glm::dvec3(0.1), 4)), 1e-6), 1e3);
  EXPECT_TRUE(std::isinf(cellForCurves(assets::Mesh{}, 1e-6)));
}

TEST(FieldResolution, ASmallCurveOnALargePartDoesNotCount) {
  // A pin whose sides are a hundredth of the whole surface.
  const assets::Mesh mesh =
      meshOf(joined(boxSoup(glm::dvec3(0.1)), moved(pegSoup({0.002, 0.040, 0.0, {64, 2}}), {0.2, 0.0, 0.0})));
  EXPECT_GT(cellForCurves(mesh, 1e-6), 1e3);
}

TEST(FieldResolution, WhatIsPredictedIsProvenByTheBake) {
  const assets::Mesh mesh = disc();
  const haptics::TriangleBvh tree(mesh, 1);
  haptics::DistanceField::Options options;
  options.threads = 1;
  options.tolerance = 0.25 * kTolerance;
  options.smallestCell = cellForCurves(mesh, kTolerance);
  const double error = haptics::DistanceField(tree, options).worstSmoothError();
  EXPECT_GT(error, 0.8 * kTolerance);
  EXPECT_LT(error, 1.5 * kTolerance);
  // Twice the cell is four times as wrong.
  options.smallestCell *= 2.0;
  EXPECT_GT(haptics::DistanceField(tree, options).worstSmoothError(), 3.0 * kTolerance);
}

}  // namespace
}  // namespace tandem::test
