// Two triangles: distances with a closed form, and for random ones the certificate of a convex problem.

#include "haptics/geometry/triangle_pair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tandem::test {
namespace {

using haptics::Triangle;
using haptics::TrianglePairGap;

Triangle scaled(const Triangle& t, double scale) { return {t.a * scale, t.b * scale, t.c * scale}; }

constexpr double kScales[] = {1e-3, 1.0, 20.0};

TEST(TrianglePair, TellsDistanceOfCornerFaceAndOfCrossedEdges) {
  const Triangle floor{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const Triangle above{{1, 1, 0.5}, {1, 1, 3}, {2, 1, 3}};        // corner over the face
  const Triangle across{{2, 2, -1}, {4, 4, 1}, {4, 4, 3}};        // past the long edge
  const Triangle crossed{{-1, -2, 1}, {-1, -2, -1}, {3, -2, 0}};  // an edge 2 m beside the floor's
  for (const double s : kScales) {
    EXPECT_NEAR(std::sqrt(haptics::nearestPoints(scaled(floor, s), scaled(above, s)).square), 0.5 * s,
                1e-15 * s);
    EXPECT_NEAR(std::sqrt(haptics::nearestPoints(scaled(floor, s), scaled(crossed, s)).square), 2.0 * s,
                1e-15 * s);
    const TrianglePairGap rim = haptics::nearestPoints(scaled(floor, s), scaled(across, s));
    EXPECT_NEAR(std::sqrt(rim.square), std::sqrt(1.0 / 3.0) * s, 1e-14 * s);
  }
}

TEST(TrianglePair, MeetsWhereAnEdgeGoesThroughAFace) {
  const Triangle floor{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const Triangle spike{{1, 1, 2}, {1, 1, -0.25}, {1.5, 1, 2}};
  const TrianglePairGap gap = haptics::nearestPoints(floor, spike);
  EXPECT_EQ(gap.square, 0.0);
  EXPECT_NEAR(gap.onA.z, 0.0, 1e-15);
  EXPECT_NEAR(haptics::standThrough(haptics::facetOf(floor), haptics::facetOf(spike)), 0.25, 1e-15);
  const Triangle touching{{1, 1, 2}, {1, 1, 0}, {1.5, 1, 2}};
  EXPECT_EQ(haptics::standThrough(haptics::facetOf(floor), haptics::facetOf(touching)), 0.0);
  EXPECT_TRUE(haptics::comeNear(floor, spike, 0.0) && haptics::comeNear(floor, touching, 1e-12));
  EXPECT_FALSE(haptics::comeNear(floor, {{1, 1, 2}, {1, 1, 0.5}, {1.5, 1, 2}}, 0.4999));
  EXPECT_NEAR(haptics::pierceShare({1, 1, 2}, {1, 1, -2}, floor), 0.5, 1e-15);
  EXPECT_LT(haptics::pierceShare({3, 3, 2}, {3, 3, -2}, floor), 0.0);
  EXPECT_LT(haptics::pierceShare({1, 1, 2}, {1, 1, 1}, floor), 0.0);
}

/// As the facets of long cylinders and fillets are: their planes are less well known, what goes through them
/// does so all the same.
TEST(TrianglePair, MeetsWhereAnEdgeGoesThroughASlenderFace) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const auto some = [&] { return glm::dvec3(u(random), u(random), u(random)); };
  int apart = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double scale = kScales[i % 3], flatness = std::pow(10.0, -1.5 + 1.4 * u(random));
    const glm::dvec3 along = glm::normalize(some()), across = glm::normalize(glm::cross(along, some()));
    const glm::dvec3 a = some(), b = a + along, c = glm::mix(a, b, 0.5 + 0.5 * u(random)) + flatness * across;
    const glm::dvec3 inside = a + (0.4 + 0.2 * u(random)) * (b - a) + (0.2 + 0.1 * u(random)) * (c - a);
    const glm::dvec3 path = glm::cross(along, across) + 2.0 * some();
    const Triangle face = scaled({a, b, c}, scale);
    const Triangle through = scaled({inside + 0.6 * path, inside - 0.7 * path, some()}, scale);
    if (std::abs(glm::dot(path, glm::cross(along, across))) < 0.1 * glm::length(path)) continue;
    apart += haptics::nearestPoints(face, through).square > 0.0 ? 1 : 0;
    apart += haptics::nearestPoints(through, face).square > 0.0 ? 1 : 0;
    ASSERT_TRUE(haptics::comeNear(face, through, 1e-9 * scale)) << i << " flatness " << flatness;
  }
  EXPECT_EQ(apart, 0);
}

TEST(TrianglePair, TakesTrianglesWithoutAreaForEdgesAndPoints) {
  const Triangle floor{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const Triangle point{{1, 1, 0.75}, {1, 1, 0.75}, {1, 1, 0.75}};
  const Triangle needle{{1, 1, 0.5}, {1, 1, 2}, {1, 1, 1}};
  const Triangle through{{1, 1, -1}, {1, 1, 2}, {1, 1, 1}};
  EXPECT_DOUBLE_EQ(haptics::nearestPoints(floor, point).square, 0.5625);
  EXPECT_DOUBLE_EQ(haptics::nearestPoints(point, floor).square, 0.5625);
  EXPECT_DOUBLE_EQ(haptics::nearestPoints(needle, floor).square, 0.25);
  EXPECT_EQ(haptics::nearestPoints(through, floor).square, 0.0);
  EXPECT_NEAR(haptics::nearestPoints(needle, point).square, 0.0, 1e-30);
}

/// Nearest points of convex sets: nothing of either lies beyond the planes through them, across their
/// offset. Returns by how much this fails, m.
double beyond(const Triangle& a, const Triangle& b, const TrianglePairGap& gap) {
  const glm::dvec3 direction = (gap.onA - gap.onB) / std::sqrt(gap.square);
  double worst = 0.0;
  for (const glm::dvec3& p : {a.a, a.b, a.c}) worst = std::max(worst, glm::dot(direction, gap.onA - p));
  for (const glm::dvec3& p : {b.a, b.b, b.c}) worst = std::max(worst, glm::dot(direction, p - gap.onB));
  return worst;
}

TEST(TrianglePair, PassesTheCertificateOfNearestPointsForRandomTriangles) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const auto some = [&] { return glm::dvec3(u(random), u(random), u(random)); };
  int apart = 0, meeting = 0, seen = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double scale = kScales[i % 3], size = std::pow(10.0, -0.3 + 0.6 * u(random));
    const auto triangle = [&] {
      const glm::dvec3 a = some(), b = a + size * some();
      const glm::dvec3 c = i % 4 == 0 ? 0.4 * a + 0.6 * b + 1e-5 * some() : a + size * some();
      return scaled({a, b, c}, scale);
    };
    const Triangle a = triangle(), b = triangle();
    const TrianglePairGap gap = haptics::nearestPoints(a, b);
    const double distance = std::sqrt(gap.square);
    // The reference knows the face of a sliver to 1e-5 of its length only.
    const double off = (i % 4 == 0 ? 1e-5 : 1e-12) * scale;
    ASSERT_FALSE(haptics::furtherThan(distance + 1e-14 * scale, haptics::facetOf(a), haptics::facetOf(b)))
        << i;
    ASSERT_LT(glm::length(haptics::closestPointOnTriangle(gap.onA, a).point - gap.onA), off) << i;
    ASSERT_LT(glm::length(haptics::closestPointOnTriangle(gap.onB, b).point - gap.onB), off) << i;
    seen += haptics::furtherThan(0.5 * distance, haptics::facetOf(a), haptics::facetOf(b)) ? 1 : 0;
    if (distance > 1e-6 * scale) {
      ++apart;
      ASSERT_LT(beyond(a, b, gap), 1e-10 * scale) << i;
    } else {
      ++meeting;
    }
  }
  EXPECT_GT(apart, 10'000);
  EXPECT_GT(seen, 8'000);
  EXPECT_GT(meeting, 300);
}

}  // namespace
}  // namespace tandem::test
