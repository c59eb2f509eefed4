#include "haptics/fields/field_path.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

std::vector<glm::dvec3> circlePoints(double radius, int count) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < count; ++i) {
    const double a = 2.0 * kPi * i / count;
    points.emplace_back(radius * std::cos(a), radius * std::sin(a), 0.0);
  }
  return points;
}

/// A lemniscate, which crosses itself at the origin after half of its way.
std::vector<glm::dvec3> figureEight(double size) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 24; ++i) {
    const double a = 2.0 * kPi * (i + 0.5) / 24;
    points.emplace_back(size * std::sin(a), size * std::sin(a) * std::cos(a), 0.0);
  }
  return points;
}

TEST(FieldPath, GoesThroughItsPointsWithOneTangentAtEach) {
  const std::vector<glm::dvec3> points{{0, 0, 0}, {1, 0, 0}, {1, 3, 0}, {1.1, 3, 1}};
  const FieldPath path(points, true, false);
  ASSERT_EQ(path.pieces(), 3.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LT(glm::distance(path.point(static_cast<double>(i)), points[i]), 1e-12);
    if (i == 0 || i + 1 == points.size()) continue;
    const double at = static_cast<double>(i);
    EXPECT_LT(glm::distance(path.tangent(at - 1e-9), path.tangent(at + 1e-9)), 1e-6);
  }
}

TEST(FieldPath, TheNearestPlaceOnALineIsItsFoot) {
  const FieldPath path({{0, 0, 0}, {2, 0, 0}, {2, 4, 0}}, false, false);
  EXPECT_LT(glm::distance(path.point(path.nearest({0.7, -1, 0.3})), glm::dvec3(0.7, 0, 0)), 1e-12);
  EXPECT_LT(glm::distance(path.point(path.nearest({3, -1, 0})), glm::dvec3(2, 0, 0)), 1e-12);
  EXPECT_EQ(path.nearest({-5, 1, 0}), 0.0);
  EXPECT_EQ(path.nearest({2, 9, 0}), 2.0);
  EXPECT_NEAR(path.length(), 6.0, 1e-12);
}

/// Expects that no place on the path is nearer to x than the nearest one.
void expectNearest(const FieldPath& path, const glm::dvec3& x) {
  double least = 1e9;
  for (double at = 0.0; at <= path.pieces(); at += 1e-3)
    least = std::min(least, glm::distance(path.point(at), x));
  EXPECT_LE(glm::distance(path.point(path.nearest(x)), x), least + 1e-9);
}

TEST(FieldPath, TheNearestPlaceIsAsNearAsAFineSearchFinds) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1.5, 1.5);
  for (const bool smooth : {true, false}) {
    for (const bool closed : {false, true}) {
      const FieldPath path(figureEight(1.0), smooth, closed);
      for (int n = 0; n < 200; ++n) {
        const double px = place(random), py = place(random), pz = 0.3 * place(random);
        expectNearest(path, {px, py, pz});
      }
    }
  }
}

/// Places that two strands are almost equally near to: the nearest of evenly spaced samples is on the wrong
/// one.
TEST(FieldPath, TheNearestPlaceIsThatOfTheNearestStrand) {
  const FieldPath open(figureEight(1.0), true, false), closed(figureEight(1.0), true, true);
  expectNearest(open, {-0.008, -0.181, 0.339});
  for (const glm::dvec3& x : {glm::dvec3(-0.024, 0.001, -0.340), glm::dvec3(-0.020, 0.003, 0.043),
                              glm::dvec3(0.026, 0.002, -0.407)})
    expectNearest(closed, x);
}

/// Places before a corner, where the slope of the distance is another one beyond it.
TEST(FieldPath, TheNearestPlaceMayBeBesideACorner) {
  const FieldPath open(figureEight(1.0), false, false), closed(figureEight(1.0), false, true);
  for (const glm::dvec3& x : {glm::dvec3(0.934, 0.118, -0.066), glm::dvec3(-0.784, 0.466, -0.184),
                              glm::dvec3(-0.609, 0.451, 0.140), glm::dvec3(-0.447, -0.260, 0.044)})
    expectNearest(open, x);
  for (const glm::dvec3& x : {glm::dvec3(0.937, -0.126, 0.018), glm::dvec3(-0.454, 0.259, -0.313)})
    expectNearest(closed, x);
}

TEST(FieldPath, AClosedCurveOfSixteenPointsIsACircleWithinAThousandth) {
  const FieldPath path(circlePoints(0.05, 16), true, true);
  for (double at = 0.0; at < 16.0; at += 0.01) EXPECT_NEAR(glm::length(path.point(at)), 0.05, 0.05 * 1e-3);
  EXPECT_NEAR(path.length(), 2.0 * kPi * 0.05, 2e-3 * path.length());
}

TEST(FieldPath, FollowingStaysOnItsStrandWhereTheCurveCrossesItself) {
  const FieldPath path(figureEight(0.05), true, true);
  // The hand goes along the curve, 2 mm beside it; at the crossing the other strand comes nearer than that.
  double at = 0.0, change = 0.0, changeOfNearest = 0.0, before = path.nearest(path.point(0.0));
  for (double s = 0.0; s < 24.0; s += 0.01) {
    const glm::dvec3 t = path.tangent(s);
    const glm::dvec3 x = path.point(s) + 0.002 * glm::dvec3(-t.y, t.x, 0.0);
    const double next = path.follow(x, at), anew = path.nearest(x);
    const auto apart = [](double a, double b) { return std::min(std::abs(a - b), 24.0 - std::abs(a - b)); };
    change = std::max(change, apart(next, at));
    changeOfNearest = std::max(changeOfNearest, apart(anew, before));
    EXPECT_LT(glm::distance(path.point(next), x), 0.002 + 1e-9);
    at = next;
    before = anew;
  }
  EXPECT_LT(change, 0.1);
  EXPECT_GT(changeOfNearest, 5.0);  // without following, the guide would have changed strands
}

}  // namespace
}  // namespace tandem::haptics
