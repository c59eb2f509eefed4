#pragma once

// Parts that others move: played out for the hand a fixed time late, predicted for the display.
//
// Haptic thread; allocates in the constructor only.

#include <array>
#include <span>
#include <vector>

#include "assets/scene/scene.h"
#include "client/hand/display_poses.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/base/tick_types.h"
#include "sync/replica/motion_trust.h"
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
  sync::MotionTrust trust{};       // whether a hand may move it like that
  sync::PosePrediction display{};  // display pose
};

class FollowedParts {
 public:
  /// Parts that others move at the same time, played out smoothly; more than that jump to their states.
  static constexpr std::size_t kMax = 64;

  /// The scene must outlive this.
  explicit FollowedParts(const assets::Scene& scene);

  FollowedPart* find(PartId part);
  /// The part's slot, or a new one that begins at this pose; null if all are taken.
  FollowedPart* findOrAdd(PartId part, const Pose& worldFromPart, sync::Micros sessionNow);
  void drop(PartId part);
  void forgetRequests();
  /// Whatever the part does until then, session time, is suspect.
  void distrust(PartId part, sync::Micros until);
  /// A part that was played out as no hand moves it, again and again; kNoPart: none.
  PartId impossible() const { return impossible_; }

  /// Plays all parts out for a tick, `elapsed` after the last one by the local clock: moved() for the hand,
  /// `display` for the window. A part that nobody owns and that has come to rest is dropped.
  void playOut(sync::Micros sessionNow, sync::Micros elapsed, sync::Micros playOutDelay,
               DisplayPoses& display);
  std::span<const haptics::PartMotion> moved() const { return {moved_.data(), moved_.size()}; }

 private:
  const assets::Scene& scene_;
  std::vector<double> radii_;                  // m, of the parts about their origins
  std::vector<sync::Micros> distrustedUntil_;  // session time, by part
  sync::Micros playedAt_ = 0;                  // session time of the last tick
  std::array<FollowedPart, kMax> slots_;       // a part keeps its slot
  PartId impossible_ = kNoPart;
  haptics::FixedVector<haptics::PartMotion, kMax> moved_;
};

}  // namespace tandem::client
