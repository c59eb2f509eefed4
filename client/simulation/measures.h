#pragma once

// What `tandem simulate` measures of one hand, by the definitions of its output. Fed once a tick.

#include <vector>

#include <glm/vec3.hpp>

#include "assets/base/pose.h"

namespace tandem::client {

struct HandSample {
  glm::dvec3 force{0.0, 0.0, 0.0};     // N, as the device applies it
  glm::dvec3 position{0.0, 0.0, 0.0};  // m, true device position
  double energyGiven = 0.0;            // J, to the hand, less what the scene's own sources gave
  bool pressing = false;               // on a fixed part
  bool still = false;                  // the person's target stands still
  bool brushes = false;                // the tool touches a part that may move
  bool pushed = false;                 // and that one does
};

/// How one hand fared. Ticks are 1 ms.
class HandMeasures {
 public:
  void add(const HandSample& sample) { samples_.push_back(sample); }
  /// The hand's site gained or lost a part in this tick.
  void roleChanged() { roleChanges_.push_back(samples_.size()); }

  /// J: the most by which the energy given ever exceeded what came in.
  double energyCreated() const;
  /// N/m: least-squares slope of force against travel while pressing, along the direction of most travel; 0
  /// without.
  double feltStiffness() const;
  /// N: largest change of force within 20 ms.
  double forceStep() const;
  /// N: the same in the 0.5 s after a role change, less its 99th percentile in the second before; 0 without.
  double handoverExcess() const;
  double rmsForce() const;
  double mostForce() const;  // N
  bool pushed() const;       // at any time
  /// Nothing diverges; the last 1.5 s, if the target is still there, move < 0.5 mm; no force changes by more
  /// than 0.3 N in 20 ms while `allStill` (one entry a tick, for all hands).
  bool stable(const std::vector<bool>& allStill) const;
  /// Whether in the last tick the bare tool came off a part that may move: who shares that part feels it, later.
  bool slidOff() const;
  /// Nothing diverges, and no force changes by more than 0.3 N in 20 ms while all hands stand still, no bare tool slides
  /// off a part (`undisturbed`, one entry a tick) and this one's is not where others may push parts against it.
  bool calm(const std::vector<bool>& undisturbed) const;
  const std::vector<HandSample>& samples() const { return samples_; }

 private:
  double forceChange(std::size_t tick) const;  // within the 20 ms that end at this tick
  bool restsUnshaken(const std::vector<bool>& undisturbed, bool brushed) const;

  std::vector<HandSample> samples_;
  std::vector<std::size_t> roleChanges_;
};

}  // namespace tandem::client
