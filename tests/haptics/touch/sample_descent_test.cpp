// From samples to the deepest place near them, against points strewn over the mesh.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "haptics/touch/sample_descent.h"
#include "tests/support/irregular_shapes.h"

namespace tandem::test {
namespace {

using haptics::ContactSample;
using haptics::PartModel;
using haptics::TriangleBvh;

constexpr double kSlack = 1e-7, kApart = 50e-6, kNear = 1e-3;  // m

struct MeshSolid {
  explicit MeshSolid(assets::Mesh m)
      : mesh(std::move(m)),
        tree(mesh),
        model(tree,
              std::make_shared<haptics::PartFeatures>(mesh, haptics::MeshEdges(mesh), true,
                                                      haptics::ContactSamples::Options{}),
              haptics::DistanceField(tree, {})) {}
  /// m, below 0 inside; of solids without acute edges.
  double distance(const glm::dvec3& p) const {
    haptics::MeshPoint nearest;
    EXPECT_TRUE(tree.closestPoint(p, 1.0, nearest));
    return std::copysign(nearest.distance, glm::dot(p - nearest.point, model.edges.normal(nearest.triangle)));
  }
  assets::Mesh mesh;
  TriangleBvh tree;
  PartModel model;
};

/// Two solids whose corners are apart, one over the other.
struct Apart {
  Apart(const MeshSolid& from, const MeshSolid& to, unsigned seed) {
    Random random(seed);
    const auto any = [&] { return between(random, -3.0, 3.0); };
    const double x = any(), y = any();
    models.from = &from.model;
    models.to = &to.model;
    models.toFromSamples.orientation = fromRotationVector({x, y, any()});
    models.toFromSamples.position = {0.0, 0.0, 0.05};
    for (int k = 0; k < 12; ++k) {
      double least = 1e300;
      for (const glm::dvec3& p : from.mesh.positions)
        least = std::min(least, to.distance(transformPoint(models.toFromSamples, p)));
      models.toFromSamples.position.z -= 0.9 * (least - kApart);
    }
  }
  haptics::SampledModels models;
};

/// m, the least distance from the target of points strewn over the triangles that come within `reach` m of
/// it.
double leastOverMesh(const Apart& apart, const MeshSolid& from, const MeshSolid& to, double reach) {
  constexpr int kCuts = 12;
  const auto distance = [&](const glm::dvec3& p) {
    return to.distance(transformPoint(apart.models.toFromSamples, p));
  };
  double least = 1e300;
  for (std::uint32_t i = 0; i < from.mesh.triangles.size(); ++i) {
    const haptics::Triangle t = from.tree.triangle(i);
    if (std::min({distance(t.a), distance(t.b), distance(t.c)}) > reach) continue;
    for (int u = 0; u <= kCuts; ++u) {
      for (int v = 0; u + v <= kCuts; ++v) {
        const glm::dvec3 across = static_cast<double>(u) * (t.b - t.a) + static_cast<double>(v) * (t.c - t.a);
        least = std::min(least, distance(t.a + across / static_cast<double>(kCuts)));
      }
    }
  }
  return least;
}

/// A sample may end in a hollow of the distance above a lower place beside it. In one of these 12 poses
/// all may, 7 um above the deepest place.
TEST(SampleDescent, GoesToTheDeepestPlaceOfThePartInAllButOnePose) {
  int moved = 0, missing = 0;
  double above = 0.0;
  for (unsigned pair = 0; pair < 3; ++pair) {
    const MeshSolid from(irregularMesh(Family::blobs, 4 - pair)), to(irregularMesh(Family::blobs, pair + 1));
    for (unsigned seed = 0; seed < 4; ++seed) {
      const Apart apart(from, to, seed);
      double seated = 1e300, alone = 1e300;
      for (const ContactSample& sample : from.model.samples.samples()) {
        const double here = to.distance(transformPoint(apart.models.toFromSamples, sample.point));
        alone = std::min(alone, here);
        if (sample.edge == assets::kNone || here > kNear) continue;
        const haptics::Seat seat = deepestNear(apart.models, sample, {kSlack, kNear}, haptics::kNoTriangle);
        const double found = seat.edge == assets::kNone ? here : to.distance(seat.point);
        EXPECT_LE(found, here);
        seated = std::min(seated, found);
        moved += seat.edge != assets::kNone ? 1 : 0;
      }
      const double least = leastOverMesh(apart, from, to, 2.0 * kNear);
      const double missed = std::min(seated, alone) - least;
      EXPECT_LT(missed, 10e-6) << pair << " " << seed;
      missing += missed > 10.0 * kSlack ? 1 : 0;
      above = std::max(above, alone - least);
    }
  }
  EXPECT_GT(moved, 100);
  EXPECT_LE(missing, 1);
  EXPECT_GT(above, 1e-5) << "the samples alone are as deep";
}

}  // namespace
}  // namespace tandem::test
