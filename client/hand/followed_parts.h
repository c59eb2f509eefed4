#pragma once

// Parts that others move: played out for the hand a fixed time late, predicted for the display.
//
// Haptic thread; allocates nothing.

#include <array>
#include <span>

#include "assets/scene/scene.h"
#include "client/hand/display_poses.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/base/tick_types.h"
#include "sync/replica/play_out.h"
#include "sync/replica/pose_prediction.h"

namespace tandem::client {

struct FollowedPart {
  PartId part = kNoPart;
  bool owned = false;  // by somebody: keep the slot
  const assets::Control* control = nullptr;
  Twist twist;                     // of the last tick, as played out
  bool asked = false;              // asked for, because it comes near to what is held here
  sync::PlayOut playOut;           // pose for the hand
  sync::PosePrediction display{};  // display pose
};

class FollowedParts {
 public:
  /// Parts that others move at the same time, played out smoothly; more than that jump to their states.
  static constexpr std::size_t kMax = 64;

  /// The scene must outlive this.
  explicit FollowedParts(const assets::Scene& scene) : scene_(scene) {}

  FollowedPart* find(PartId part);
  /// The part's slot, or a new one that begins at this pose; null if all are taken.
  FollowedPart* findOrAdd(PartId part, const Pose& worldFromPart, sync::Micros sessionNow);
  void drop(PartId part);
  void forgetRequests();

  /// Plays all parts out for a tick: moved() for the hand, `display` for the window. A part that nobody owns
  /// and that has come to rest is dropped.
  void playOut(sync::Micros sessionNow, sync::Micros playOutDelay, DisplayPoses& display);
  std::span<const haptics::PartMotion> moved() const { return {moved_.data(), moved_.size()}; }

 private:
  const assets::Scene& scene_;
  std::array<FollowedPart, kMax> slots_;  // a part keeps its slot
  haptics::FixedVector<haptics::PartMotion, kMax> moved_;
};

}  // namespace tandem::client
