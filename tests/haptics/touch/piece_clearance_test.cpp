// The bound of how far pieces of edges are from a neighbour, by which they are left out of a step: none is
// nearer than it says.

#include <gtest/gtest.h>

#include <algorithm>

#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/contact_world.h"
#include "haptics/touch/near_samples.h"
#include "haptics/touch/piece_clearance.h"
#include "tests/support/irregular_shapes.h"
#include "tests/support/part_cases.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using haptics::DistanceField;

/// How pieces of one part's edges stand before another one.
struct Pieces {
  int seen = 0;       // outside, where a field knows directions
  int farther = 0;    // whose bound says more than the whole length of the piece would
  int nearer = 0;     // that come nearer to the mesh than the bound says, by more than the fields' tolerance
  double most = 0.0;  // m by which one does
};

/// `share` of a piece is asked for; 0 takes the sample for all of it.
Pieces judge(Family family, unsigned seed, float share) {
  assets::Scene scene = sceneOfParts({{"edges", irregularMesh(family, seed), {}, true},
                                      {"target", irregularMesh(family, seed + 100), {}, true}});
  haptics::ContactScene contact(scene, 1);
  contact.modelParts();
  const haptics::ContactWorld world(contact);
  const haptics::PartModel &from = *world.model(0), &to = *world.model(1);
  const auto smooth = 2.0f * static_cast<float>(to.field.tolerance()),
             rough = std::max(smooth, 0.12f * static_cast<float>(to.field.smallestCell()));
  Random random(seed);
  Pieces pieces;
  for (int k = 0; k < 16; ++k) {
    const Pose pose{0.03 * anyVector(random), fromRotationVector(3.0 * anyVector(random))};
    const haptics::FloatMotion motion(pose, to.field.origin());
    for (const haptics::ContactSample& sample : from.samples.samples()) {
      haptics::ContactPatch edge;
      if (!(sample.along > 0.0f) || !from.patchOf(sample, edge)) continue;
      const glm::vec3 place = motion(glm::vec3(sample.point)),
                      along = sample.along * glm::vec3(pose.orientation * edge.axis);
      const DistanceField::Reading here = to.field.read(place);
      if (here.error > rough || here.distance < here.error || here.distance > 4.0f * sample.along) continue;
      const float least = haptics::leastAlong(to.field, place, here, share * along, rough);
      ++pieces.seen;
      pieces.farther += least > here.distance - here.error - sample.along ? 1 : 0;
      double nearest = 1e300;
      for (int i = -16; i <= 16; ++i) {
        const glm::dvec3 p = to.field.origin() + glm::dvec3(place + static_cast<float>(i) / 16.0f * along);
        haptics::MeshPoint found;
        if (to.tree->closestPoint(p, nearest, found)) nearest = found.distance;
      }
      const double off = static_cast<double>(least) - nearest;
      pieces.most = std::max(pieces.most, off);
      pieces.nearer += off > to.field.tolerance() ? 1 : 0;
    }
  }
  return pieces;
}

TEST(PieceClearance, NoPieceIsNearerThanItsBoundSays) {
  for (const Family family : {Family::blobs, Family::blocks, Family::turned}) {
    const Pieces pieces = judge(family, 1, 1.0f);
    EXPECT_EQ(pieces.nearer, 0) << pieces.most << " m";
    EXPECT_GT(pieces.seen, 100);
    EXPECT_GT(pieces.farther, pieces.seen / 2) << "the bound is worth its two readings";
  }
}

TEST(PieceClearance, ABoundThatKnowsTheSampleAloneLies) {
  // The control.
  EXPECT_GT(judge(Family::blocks, 1, 0.0f).nearer, 50);
}

}  // namespace
}  // namespace tandem::test
