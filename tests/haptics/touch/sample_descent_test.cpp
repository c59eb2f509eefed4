// From samples to the deepest place near them, against points strewn over the mesh.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "haptics/touch/sample_descent.h"
#include "tests/support/irregular_shapes.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using haptics::ContactSample;
using haptics::PartModel;
using haptics::TriangleBvh;

constexpr double kSlack = 1e-7, kApart = 50e-6, kNear = 1e-3;  // m

struct MeshSolid {
  explicit MeshSolid(assets::Mesh m, const haptics::ContactSamples::Options& sampling = {})
      : mesh(std::move(m)),
        tree(mesh),
        model(tree, std::make_shared<haptics::PartFeatures>(mesh, haptics::MeshEdges(mesh), true, sampling),
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

/// What the samples of one part find of the deepest place in the other.
struct Descents {
  double alone = 1e300;   // m, the least distance of a sample from the other part
  double seated = 1e300;  // m, the same of the samples and the places to which they descend
  int moved = 0;          // samples that descend at all
};

Descents descend(const haptics::SampledModels& models, const MeshSolid& to) {
  Descents all;
  for (const ContactSample& sample : models.from->samples.samples()) {
    const double here = to.distance(transformPoint(models.toFromSamples, sample.point));
    all.alone = std::min(all.alone, here);
    all.seated = std::min(all.seated, here);
    if (sample.edge == assets::kNone || here > kNear) continue;
    const haptics::Seat seat = deepestNear(models, sample, {kSlack, kNear}, haptics::kNoTriangle);
    if (seat.edge == assets::kNone) continue;
    const double found = to.distance(seat.point);
    EXPECT_LE(found, here);
    all.seated = std::min(all.seated, found);
    ++all.moved;
  }
  return all;
}

/// A descent goes along the edges of its own part. Where the deepest place is inside a face, a corner or an
/// edge of the other part touches that face, and a descent of the other part goes there.
TEST(SampleDescent, OfOnePartOrTheOtherGoesToTheDeepestPlace) {
  int moved = 0, byTheOther = 0;
  double above = 0.0;
  for (const unsigned shape : {2u, 6u, 8u}) {
    const MeshSolid from(irregularMesh(Family::blobs, shape)),
        to(irregularMesh(Family::blobs, shape % 8 + 1));
    for (unsigned seed = 0; seed < 4; ++seed) {
      const Apart apart(from, to, seed);
      const Descents one = descend(apart.models, to);
      const Descents other = descend({&to.model, &from.model, inverse(apart.models.toFromSamples)}, from);
      const double least = leastOverMesh(apart, from, to, 2.0 * kNear);
      EXPECT_LT(std::min(one.seated, other.seated), least + 10.0 * kSlack) << shape << " " << seed;
      moved += one.moved + other.moved;
      byTheOther += one.seated > least + 10.0 * kSlack ? 1 : 0;
      above = std::max(above, std::min(one.alone, other.alone) - least);
    }
  }
  EXPECT_GT(moved, 100);
  EXPECT_GT(byTheOther, 0) << "one part's descents are enough";
  EXPECT_GT(above, 1e-5) << "the samples alone are as deep";
}

/// m over the target, of the place where a descent from a sample and from `known` ends.
double seatedHeight(const haptics::SampledModels& models, const MeshSolid& to, const ContactSample& sample,
                    const haptics::EdgePlace& known) {
  const haptics::Seat seat = deepestNear(models, sample, {kSlack, kNear}, haptics::kNoTriangle, known);
  const bool moved = seat.edge != assets::kNone;
  return to.distance(moved ? seat.point : transformPoint(models.toFromSamples, sample.point));
}

/// Where descents of other samples ended, a sample near by may not arrive by itself.
TEST(SampleDescent, FromAKnownPlaceEndsNoHigherThanThere) {
  const MeshSolid from(irregularMesh(Family::blobs, 2)), to(irregularMesh(Family::blobs, 3));
  int seen = 0, missed = 0;
  for (unsigned seed = 0; seed < 4; ++seed) {
    const haptics::SampledModels models = Apart(from, to, seed).models;
    std::vector<haptics::EdgePlace> ends;
    const auto forEachNear = [&](auto&& visit) {
      for (const ContactSample& sample : from.model.samples.samples())
        if (haptics::ContactSamples::isSmooth(sample) &&
            to.distance(transformPoint(models.toFromSamples, sample.point)) < kNear)
          visit(sample);
    };
    forEachNear([&](const ContactSample& sample) {
      const haptics::Seat seat = deepestNear(models, sample, {kSlack, kNear}, haptics::kNoTriangle);
      if (seat.edge != assets::kNone)
        ends.push_back({seat.edge, transformPoint(inverse(models.toFromSamples), seat.point)});
    });
    forEachNear([&](const ContactSample& sample) {
      const double alone = seatedHeight(models, to, sample, {});
      for (const haptics::EdgePlace& end : ends) {
        if (glm::distance(sample.point, end.point) > from.model.samples.extent(sample)) continue;
        const double there = to.distance(transformPoint(models.toFromSamples, end.point));
        EXPECT_LE(seatedHeight(models, to, sample, end), std::min(alone, there) + kSlack);
        missed += alone > there + 10.0 * kSlack ? 1 : 0;
        ++seen;
      }
    });
  }
  EXPECT_GT(seen, 100);
  EXPECT_GT(missed, 0);
}

/// A piece of edge lies over a ridge beside a hollow, where the tangents at its ends say that it is not lower
/// than where they meet.
TEST(SampleDescent, AlongAnEdgeLooksBehindTheMeetingOfTangentsOverAHollow) {
  constexpr double kMm = 1e-3, kUm = 1e-6, kDeepest = 5.0 * kUm;
  const MeshSolid target(meshOf(prismSoup({{-0.8 * kMm, -0.5 * kMm},
                                           {0.5 * kMm, -0.5 * kMm},
                                           {0.5 * kMm, -110.0 * kUm},
                                           {-0.09 * kMm, 2.8 * kUm},
                                           {-0.13 * kMm, kDeepest},
                                           {-0.42 * kMm, -3.5 * kUm},
                                           {-0.8 * kMm, -6.0 * kUm}},
                                          2.0 * kMm))),
      bar(boxMesh(glm::dvec3(kMm)), {.spacing = kMm});
  haptics::SampledModels models{&bar.model, &target.model, {}};
  models.toFromSamples.orientation = fromRotationVector({0.25 * kPi, 0.0, 0.0});
  models.toFromSamples.position = {0.0, std::sqrt(0.5) * kMm, kMm};
  int seen = 0;
  for (const ContactSample& sample : bar.model.samples.samples()) {
    if (glm::length(transformPoint(models.toFromSamples, sample.point) - glm::dvec3(0.0, 0.0, kMm)) > kUm)
      continue;
    const haptics::Seat seat = deepestNear(models, sample, {kSlack, kNear}, haptics::kNoTriangle);
    EXPECT_NE(seat.edge, assets::kNone);
    EXPECT_LT(target.distance(seat.point), -0.95 * kDeepest);
    ++seen;
  }
  EXPECT_EQ(seen, 1);
}

/// A long cylinder is tilted over a table: its edges fall towards the table past every sample on them, and a
/// descent from there is worth its time.
TEST(SampleDescent, IsWorthItAlongALongEdgeThatFalls) {
  const MeshSolid peg(meshOf(pegSoup({0.005, 0.03, 0.001, {64, 3}}))),
      table(boxMesh(glm::dvec3(0.06, 0.06, 0.01)));
  haptics::SampledModels models{&peg.model, &table.model, {}};
  models.toFromSamples.orientation = fromRotationVector({0.0, 1.54, 0.0});
  double lowest = 1e300;
  for (const glm::dvec3& p : peg.mesh.positions)
    lowest = std::min(lowest, transformPoint(models.toFromSamples, p).z);
  models.toFromSamples.position.z = 0.005 - lowest + kApart;
  int seen = 0;
  for (const ContactSample& sample : peg.model.samples.samples()) {
    const glm::dvec3 place = transformPoint(models.toFromSamples, sample.point);
    const double height = table.distance(place),
                 end = std::min(sample.point.z - 0.001, 0.03 - sample.point.z);
    if (!haptics::ContactSamples::isSmooth(sample) || height > kNear ||
        end < peg.model.samples.extent(sample))
      continue;
    const haptics::LevelBounds bounds{height, 1e-6, 1e-3};
    EXPECT_FALSE(isLevel(models, sample, bounds, {0.0, 0.0, 1.0}, true)) << 1e3 * sample.point.z;
    ++seen;
  }
  EXPECT_GT(seen, 10);
}

}  // namespace
}  // namespace tandem::test
