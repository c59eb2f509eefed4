#pragma once

// How deep two parts are in each other beyond what an interference fit explains: the deepest sample of either
// in the other one, taken back by the fit.
//
// Fields say of most samples how deep they may be at most, and of some how deep they are at least. What is
// left is measured exactly, from what may be deepest on, until nothing may be deeper than what is known.
// What has been measured once bounds how deep the sample may be beside that place, when the fit has changed.
//
// 1. Works in portions (counted_work.h). Free of allocation.

#include <cstdint>
#include <optional>

#include "haptics/base/fixed_vector.h"
#include "haptics/fit/counted_work.h"
#include "haptics/fit/interference_fit.h"
#include "haptics/fit/part_pair.h"
#include "haptics/touch/near_samples.h"

namespace tandem::haptics {

class UnexplainedDepth {
 public:
  static constexpr double kExact = 0.1;  // tolerances of a depth that counts as 0

  /// Begins for the samples of a pair. Depths of more than `enough` m are not told apart.
  void begin(const PartPair& pair, bool firstIsHollow, double enough);
  /// Begins anew for the same pair, whose fit has become deeper.
  void beginAgain();
  /// Goes on; true once depth() is known. The fit is the same until then.
  bool advance(const InterferenceFit& fit, CountedWork& work);
  /// m; more than `enough` where it is that, or where finding out takes too long.
  double depth() const { return depth_; }
  /// Whether finding out took too long.
  bool isUnknown() const { return depth_ == kUnknown; }

 private:
  static constexpr std::size_t kMaxWaiting = 512, kMaxMeasured = 4096;
  static constexpr int kMaxQueries = 2000;
  static constexpr double kUnknown = 1e300;  // m

  /// A place of a sample that may be deeper than what is known.
  struct Place {
    double most = 0.0;   // m, how deep
    glm::dvec3 at{0.0};  // m, frame of the part that it may be in
    const PartModel* in = nullptr;
    bool surelyInside = false;
    std::size_t seen = 0;  // samples that were seen before it
    bool operator<(const Place& other) const { return most < other.most; }
  };
  /// What has been measured of a sample: no place within r m of this one is deeper than `most` + r.
  struct Measured {
    glm::dvec3 at{0.0};      // m
    double most = kUnknown;  // m; below 0 outside
  };
  void beginSide(bool ofFirst);
  /// m, the most that a sample may be deep at a place, by what has been measured of it.
  double mostOf(std::size_t seen, const glm::dvec3& at) const;
  void see(const InterferenceFit& fit, std::uint32_t sample);
  /// Measures the place that may be deepest.
  void measureDeepest();

  PartPair pair_;
  bool firstIsHollow_ = false, ofFirst_ = true;
  double enough_ = 0.0, depth_ = 0.0;  // m
  int queries_ = 0;
  SampledModels side_;
  std::optional<NearSamples> near_;               // of the present side
  FixedVector<Place, kMaxWaiting> waiting_;       // a heap, the deepest first
  std::size_t seen_ = 0;                          // samples, which come in the same order whatever the fit
  FixedVector<Measured, kMaxMeasured> measured_;  // of the first samples that are seen
};

}  // namespace tandem::haptics
