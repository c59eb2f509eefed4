#pragma once

namespace tandem::haptics {

/// What a tick may spend on contact between parts. With less effort a tick is faster and parts move less
/// far than they could; while `exact` holds they never enter each other.
struct ContactEffort {
  static constexpr int kTakeAtOnce = 1'000'000'000;  // for `taking`, where no hand waits for a tick

  int steps = 4;            // at most, 1 to 4; the rest of a fast motion is made up in the next ticks
  int sampleQueries = 600;  // at most, of all steps: rows measured or made active
  bool exact = true;    // measure triangles where a field is not reliable; false: use its reading as it is
  bool descend = true;  // go to the deepest place near a sample; false: measure at the samples alone
  int taking = 6000;    // for parts that begin to move: units of work of some 50 ns
};

}  // namespace tandem::haptics
