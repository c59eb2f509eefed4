// Overlaps that are measured in portions are those measured at once, bit by bit, and no portion is exceeded.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/fit/overlap_measure.h"
#include "haptics/scene/contact_scene_data.h"
#include "tests/support/part_cases.h"

namespace tandem::test {
namespace {

using haptics::CountedWork;
using haptics::MeasuredOverlap;
using haptics::OverlapMeasure;

/// All that a measurement has found.
struct Found {
  MeasuredOverlap overlap;
  bool fits = false;
  double fitDepth = 0.0;                   // m
  std::vector<glm::dvec3> shifts, hinted;  // m, of the samples of the first part; each with the last hint
  int portions = 0, work = 0;              // work: of all portions
};

/// The two parts of a scene with their models, of which one begins to move.
class Pairing {
 public:
  explicit Pairing(assets::Scene scene, PartId held = 1)
      : scene_(std::move(scene)), contact_(scene_, 1), held_(held) {
    contact_.modelParts();
    const Pose other = scene_.parts[1 - held].worldFromPart;
    pair_ = {model(held), model(1 - held), inverse(other) * scene_.parts[held].worldFromPart};
  }
  Pairing(const Pairing&) = delete;

  Found measure(int portion) const {
    OverlapMeasure measure;
    measure.begin(pair_, contact_.data().colliders[held_].centre, true, {});
    Found found;
    for (bool done = false; !done; ++found.portions) {
      CountedWork work(portion);
      done = measure.advance(work);
      EXPECT_LE(work.spent(), portion);
      EXPECT_TRUE(done || work.spent() > 0);
      found.work += work.spent();
    }
    found.overlap = measure.measured();
    if (const haptics::InterferenceFit* const fit = measure.fit()) {
      found.fits = true;
      found.fitDepth = fit->depth();
      haptics::InterferenceFit::Hint hint;
      for (const haptics::ContactSample& sample : pair_.first->samples.samples()) {
        found.shifts.push_back(fit->shift(pair_.side(true), sample, found.overlap.firstIsHollow));
        found.hinted.push_back(fit->shift(pair_.side(true), sample, found.overlap.firstIsHollow, hint));
      }
    }
    return found;
  }
  /// The same in a hurry, with work that does for this much.
  Found measureInAHurry(int most) const {
    OverlapMeasure measure;
    measure.begin(pair_, contact_.data().colliders[held_].centre, true, {});
    CountedWork work(most, true);
    EXPECT_TRUE(measure.advance(work));
    Found found;
    found.overlap = measure.measured();
    found.fits = measure.fit() != nullptr;
    found.work = work.spent();
    return found;
  }

 private:
  const haptics::PartModel* model(PartId part) const { return contact_.data().colliders[part].model; }

  assets::Scene scene_;
  haptics::ContactScene contact_;
  PartId held_;
  haptics::PartPair pair_;
};

constexpr int kAtOnce = 1'000'000'000;

void expectSame(const Found& a, const Found& b) {
  EXPECT_EQ(a.overlap.depth, b.overlap.depth);
  EXPECT_EQ(a.overlap.inFirst.min, b.overlap.inFirst.min);
  EXPECT_EQ(a.overlap.inFirst.max, b.overlap.inFirst.max);
  EXPECT_EQ(a.overlap.inOther.min, b.overlap.inOther.min);
  EXPECT_EQ(a.overlap.inOther.max, b.overlap.inOther.max);
  EXPECT_EQ(a.overlap.contained, b.overlap.contained);
  EXPECT_EQ(a.overlap.exit, b.overlap.exit);
  EXPECT_EQ(a.overlap.firstIsHollow, b.overlap.firstIsHollow);
  EXPECT_EQ(a.fits, b.fits);
  EXPECT_EQ(a.fitDepth, b.fitDepth);
  EXPECT_EQ(a.shifts, b.shifts);
  EXPECT_EQ(a.work, b.work);
}

/// Returns what is found at once.
Found expectSameInPortions(const Pairing& pairing) {
  const Found atOnce = pairing.measure(kAtOnce);
  EXPECT_EQ(atOnce.portions, 1);
  for (const int portion : {CountedWork::kLargest, 6000, 20'011}) {
    SCOPED_TRACE(portion);
    expectSame(pairing.measure(portion), atOnce);
  }
  return atOnce;
}

/// A peg that is 0.1 mm too large for its bore of 10 mm, as the block's part or as the part that moves.
assets::Scene pegInItsBore(bool plugMoves) {
  const CasePart plug{.name = "peg",
                      .mesh = meshOf(moved(pegSoup({.radius = 0.0101, .length = 0.03, .facets = {48, 4}}),
                                           {0.0, 0.0, -0.02})),
                      .movable = true};
  const CasePart seat{
      .name = "block",
      .mesh = meshOf(boredBlockSoup({.depth = 0.02, .height = 0.02, .fit = Fit::within, .facets = {48, 4}})),
      .movable = true};
  return sceneOfParts(plugMoves ? std::vector<CasePart>{seat, plug} : std::vector<CasePart>{plug, seat});
}

TEST(OverlapMeasure, OfAPlugInItsSeatIsTheSameInPortions) {
  const Found plug = expectSameInPortions(Pairing(pegInItsBore(true)));
  EXPECT_TRUE(plug.fits);
  EXPECT_FALSE(plug.overlap.firstIsHollow);
  const Found seat = expectSameInPortions(Pairing(pegInItsBore(false)));
  EXPECT_TRUE(seat.fits);
  EXPECT_TRUE(seat.overlap.firstIsHollow);
}

TEST(OverlapMeasure, AHintChangesNoShiftOfAFit) {
  for (const bool plugMoves : {true, false}) {
    const Found found = Pairing(pegInItsBore(plugMoves)).measure(kAtOnce);
    EXPECT_EQ(found.hinted, found.shifts);
    // A hint that was believed of samples that do not face its points would shift these too.
    const auto rests = [](const glm::dvec3& shift) { return shift == glm::dvec3(0.0); };
    const auto resting = std::count_if(found.shifts.begin(), found.shifts.end(), rests);
    EXPECT_GT(resting, 0);
    EXPECT_LT(resting, static_cast<std::ptrdiff_t>(found.shifts.size()));
  }
}

TEST(OverlapMeasure, OfDirtyMeshesIsTheSameInPortions) {
  for (const Dirt dirt : {Dirt::none, Dirt::insideOut, Dirt::flipped, Dirt::torn}) {
    PartCase given = dirtyShellsCase(dirt);
    SCOPED_TRACE(given.name);
    given.scene.parts[given.held].worldFromPart = given.path(0.0);
    given.scene.parts[given.held].worldFromPart.position.z = 0.0048;  // 0.2 mm deep
    const Found found = expectSameInPortions(Pairing(std::move(given.scene), given.held));
    EXPECT_NEAR(found.overlap.depth, 0.2e-3, 1e-5);
    EXPECT_FALSE(found.fits);
  }
}

TEST(OverlapMeasure, OfAPartWhollyInsideAnotherIsTheSameInPortions) {
  PartCase given = cubeInBlockCase({0.020, 0.003, -0.001});
  const Found found = expectSameInPortions(Pairing(std::move(given.scene), given.held));
  EXPECT_TRUE(found.overlap.contained);
  EXPECT_GT(found.overlap.exit.x, 0.99);
}

/// In a hurry the seat may be missed, and the overlap is no less deep than it is.
TEST(OverlapMeasure, InAHurryLeavesOutWhatItCannotAfford) {
  const Pairing pairing(pegInItsBore(true));
  const Found whole = pairing.measure(kAtOnce), hurried = pairing.measureInAHurry(2 * whole.work),
              hasty = pairing.measureInAHurry(500);
  EXPECT_TRUE(hurried.fits);
  EXPECT_EQ(hurried.overlap.depth, whole.overlap.depth);
  EXPECT_FALSE(hasty.fits);
  EXPECT_GE(hasty.overlap.depth, whole.overlap.depth);
  EXPECT_LT(hasty.work, whole.work / 2);
}

}  // namespace
}  // namespace tandem::test
