#pragma once

// How two parts stand in each other when the first of them begins to move here. In this order
//
// known fit  whether an interference fit of the two still explains it: then nothing else is measured;
// sides      how deep the samples of the other part are in the first one, then those of the first one in it;
// exit       for a part wholly inside the other, the way out;
// fit        for any other, whether the overlap is an interference fit (fit_search.h).
//
// 1. Works in portions (counted_work.h): measured in many or at once, the result has the same bits. In a
//    hurry it leaves out what it cannot afford: what may be inside counts as inside then, a known fit stays,
//    and no other one is found.
// 2. Alone the constructor allocates. Models must outlive a measurement.

#include <optional>

#include "assets/scene/scene.h"
#include "haptics/fit/counted_work.h"
#include "haptics/fit/fit_search.h"
#include "haptics/fit/part_pair.h"
#include "haptics/fit/unexplained_depth.h"
#include "haptics/touch/near_samples.h"

namespace tandem::haptics {

/// What has been measured.
struct MeasuredOverlap {
  double depth = 0.0;               // m; 0: the parts are not in each other
  assets::Bounds inFirst, inOther;  // m, part frames: where samples are inside, and beside by their spacing
  bool contained = false;           // the first part is wholly inside the other
  glm::dvec3 exit{0.0, 0.0, 0.0};   // of a contained part, unit, in the frame of the other
  bool keepsFit = false;            // the known fit still explains it, and nothing else was measured
  bool firstIsHollow = false;       // of the fit that was found
};

class OverlapMeasure {
 public:
  /// A fit that is known of a pair.
  struct KnownFit {
    const InterferenceFit* fit = nullptr;  // null: none
    bool firstIsHollow = false;
  };

  /// Begins to measure a pair. `centre`: m, of the first part's ball, in its frame. Without `exits` it does
  /// not count as wholly inside the other.
  void begin(const PartPair& pair, const glm::dvec3& centre, bool exits, const KnownFit& known);
  /// Goes on; true once it is measured. The known fit is there until then.
  bool advance(CountedWork& work);
  const MeasuredOverlap& measured() const { return measured_; }
  /// The fit that was found, or null.
  const InterferenceFit* fit() const { return phase_ == Phase::fit ? search_.found() : nullptr; }

 private:
  enum class Phase { knownFit, ofOther, ofFirst, exit, fit };
  static constexpr int kMaxQueries = 400;    // exact distances of one pair
  static constexpr double kExplained = 2.0;  // tolerances that parts may be deeper than a fit explains

  /// The overlap as the samples of one part measure it.
  struct Side {
    double depth = 0.0;  // m
    bool allInside = true;
    assets::Bounds inSampled, inTarget;  // m, part frames
  };
  void beginSide(Phase ofWhich);
  /// Goes on with a side; true once all its samples are seen.
  bool advanceSide(CountedWork& work);
  void measureSample(const ContactSample& sample, const DistanceField::Reading& read, CountedWork& work);
  void note(double depth, const glm::dvec3& point, const glm::dvec3& inTarget);
  /// Puts the sides together and goes on to what follows; false if the parts are not in each other.
  bool endSides();
  bool mayFit() const;
  /// The direction of the shortest path out of the other part; unit, other part's frame.
  glm::dvec3 exitDirection() const;

  PartPair pair_;
  glm::dvec3 centre_{0.0};
  bool exits_ = true;
  KnownFit known_;
  Phase phase_ = Phase::fit;
  int queries_ = 0;
  SampledModels models_;  // of the present side
  std::optional<NearSamples> near_;
  Side side_;                  // the present one; the second one extends the bounds of the first
  double depthOfOther_ = 0.0;  // m, of the side that came first
  MeasuredOverlap measured_;
  UnexplainedDepth unexplained_;
  FitSearch search_;
};

}  // namespace tandem::haptics
