#include "haptics/fit/fit_search.h"

#include <algorithm>

namespace tandem::haptics {
namespace {

constexpr int kMaxDepthRounds = 4;  // of making a fit as deep as it has to be
// Tolerances by which a seat is made roomier than it was measured, and depths of an overlap above which a fit
// would let the parts in further than they were.
constexpr double kRoom = 1.0, kMuchDeeper = 1.1;
// Depths of an overlap up to which the seat's wall is in the plug.
constexpr double kDeepest = 1.5;
// Places that are looked at in one piece of work. Each costs a reading, and a comparison with the known
// points, kPoints of which take one unit.
constexpr int kPlacesAtOnce = 16, kPlace = CountedWork::kReading, kPoints = 32;
constexpr int kIndexing = 4;  // a point

}  // namespace

void FitSearch::begin(const PartPair& pair, double depth, const assets::Bounds& inFirst,
                      const assets::Bounds& inOther) {
  pair_ = pair;
  overlap_ = depth;
  inFirst_ = inFirst;
  inOther_ = inOther;
  found_ = false;
  beginWall(false);
}

void FitSearch::beginWall(bool firstIsHollow) {
  firstIsHollow_ = firstIsHollow;
  plugFromHollow_ = pair_.side(firstIsHollow);
  place_ = 0;
  phase_ = Phase::wall;
  if (!fit_->begin(firstIsHollow ? inFirst_ : inOther_)) fail();
}

void FitSearch::fail() {
  if (firstIsHollow_)
    phase_ = Phase::over;
  else
    beginWall(true);
}

bool FitSearch::advance(CountedWork& work) {
  while (phase_ != Phase::over) {
    if (phase_ == Phase::depth) {
      if (!unexplained_.advance(*fit_, work)) return false;
      endRound();
      continue;
    }
    const bool looked = place_ == fit_->places();
    const int points = static_cast<int>(fit_->points()), most = static_cast<int>(InterferenceFit::kMaxPoints);
    const int cost = looked ? kIndexing * points : kPlacesAtOnce * (kPlace + most / kPoints);
    if (work.pauses(cost)) return false;
    if (!work.affords(cost)) {
      phase_ = Phase::over;
    } else if (!looked) {
      lookOn(work);
    } else {
      work.spend(cost);
      fit_->end() ? beginDepth() : fail();
    }
  }
  return true;
}

void FitSearch::lookOn(CountedWork& work) {
  const int end = std::min(place_ + kPlacesAtOnce, fit_->places());
  for (; place_ < end; ++place_) {
    work.spend(kPlace + static_cast<int>(fit_->points()) / kPoints);
    if (!fit_->lookAt(place_, plugFromHollow_, kDeepest * overlap_)) return fail();
  }
}

void FitSearch::beginDepth() {
  phase_ = Phase::depth;
  round_ = 0;
  unexplained_.begin(pair_, firstIsHollow_, kMuchDeeper * overlap_);
}

void FitSearch::endRound() {
  const double left = unexplained_.depth(), tolerance = pair_.other->field.tolerance(),
               explained = UnexplainedDepth::kExact * tolerance;
  if (left > kMuchDeeper * overlap_) return fail();
  fit_->setDepth(fit_->depth() + left);
  if (++round_ < kMaxDepthRounds && left > explained) return unexplained_.beginAgain();
  fit_->setDepth(fit_->depth() + kRoom * tolerance);
  found_ = left <= explained && fit_->depth() < kMuchDeeper * overlap_;
  if (found_)
    phase_ = Phase::over;
  else
    fail();
}

}  // namespace tandem::haptics
