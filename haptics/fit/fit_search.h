#pragma once

// Finds out whether the overlap of two parts is an interference fit: first with the seat in the other part,
// then with the seat in the part that begins to move. Of each
//
// wall      the places of a grid around the overlap are looked at for the seat's wall;
// depth     the fit is made deeper by what it leaves unexplained, in a few rounds, until it explains all.
//
// 1. Works in portions (counted_work.h). Alone the constructor allocates.

#include <memory>

#include "haptics/fit/interference_fit.h"
#include "haptics/fit/part_pair.h"
#include "haptics/fit/unexplained_depth.h"

namespace tandem::haptics {

class FitSearch {
 public:
  FitSearch() : fit_(std::make_unique<InterferenceFit>()) {}

  /// Begins for parts that are `depth` m deep in each other, within these boxes (m, part frames).
  void begin(const PartPair& pair, double depth, const assets::Bounds& inFirst,
             const assets::Bounds& inOther);
  /// Goes on; true once found() is known. In a hurry it gives up.
  bool advance(CountedWork& work);
  /// The fit, or null.
  const InterferenceFit* found() const { return found_ ? fit_.get() : nullptr; }
  bool firstIsHollow() const { return firstIsHollow_; }

 private:
  enum class Phase { wall, depth, over };

  void beginWall(bool firstIsHollow);
  /// Looks at one row of places.
  void lookOn(CountedWork& work);
  void beginDepth();
  void endRound();
  /// Goes on with the seat in the first part, or ends.
  void fail();

  PartPair pair_;
  double overlap_ = 0.0;  // m
  assets::Bounds inFirst_, inOther_;
  Phase phase_ = Phase::over;
  bool firstIsHollow_ = false, found_ = false;
  SampledModels plugFromHollow_;
  int place_ = 0, round_ = 0;
  UnexplainedDepth unexplained_;
  std::unique_ptr<InterferenceFit> fit_;
};

}  // namespace tandem::haptics
