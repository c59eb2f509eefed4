#pragma once

// The parts that others move, from one tick to the next.
//
// 1. Many parts that move in one tick are kept out of the scene tree (ContactWorld::beginMotions()).
// 2. A part whose motion is not listed in a tick stands still: its twist is zero from then on.
// 3. Motions come from elsewhere: one that cannot be used is dropped, never trusted, and a velocity that the
//    poses do not bear out is replaced by theirs.
// 4. Only the constructor allocates.

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "haptics/base/tick_types.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

// More parts than this that move at once are kept out of the scene tree.
inline constexpr std::size_t kManyMoving = 32;

inline bool samePose(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation == b.orientation;
}

/// Moves one part; calls moved(part, before, twistBefore) if its pose has changed.
template <typename Moved>
void movePart(ContactWorld& world, PartId part, const Pose& worldFromPart, const Twist& twist,
              Moved&& moved) {
  const Pose before = world.pose(part);
  if (samePose(before, worldFromPart)) return world.setTwist(part, twist);
  const Twist twistBefore = world.twist(part);
  world.setPose(part, worldFromPart, twist);
  moved(part, before, twistBefore);
}

/// The twist of a motion from `before` within dt seconds: the stated one if the change of pose bears it out,
/// else that of the change. dt = 0: the stated one.
Twist borneOutTwist(const Pose& before, const PartMotion& motion, double dt);

class MovedParts {
 public:
  /// For a scene of so many parts.
  explicit MovedParts(std::size_t parts);

  /// Carries out the motions of one tick but those of parts that isOwned(part) names, and calls
  /// moved(motion, before, twistBefore) after each change of a pose that may concern the region. `region`:
  /// where this tick is going to ask, m, world. `dt`: s, of the tick; 0: velocities are believed. False if a
  /// motion was dropped because it cannot be used.
  template <typename IsOwned, typename Moved>
  [[nodiscard]] bool apply(ContactWorld& world, std::span<const PartMotion> motions,
                           const assets::Bounds& region, double dt, IsOwned&& isOwned, Moved&& moved);

 private:
  static bool isUsable(const ContactWorld& world, const PartMotion& motion);
  void begin();
  void note(PartId part);
  /// Zeroes the twist of what moved in the last tick and not in this one.
  void stopOthers(ContactWorld& world) const;

  std::vector<std::uint32_t> near_;     // indices of this tick's motions near the tool; capacity for all
  std::vector<PartId> moving_;          // parts with a twist from this tick; capacity for all
  std::vector<PartId> movedBefore_;     // those of the last tick
  std::vector<std::uint32_t> movedAt_;  // per part: the last tick in which others moved it
  std::uint32_t tickNumber_ = 0;        // wraps: it is only compared with movedAt_ for equality
};

template <typename IsOwned, typename Moved>
bool MovedParts::apply(ContactWorld& world, std::span<const PartMotion> motions, const assets::Bounds& region,
                       double dt, IsOwned&& isOwned, Moved&& moved) {
  bool usable = true;
  const auto takes = [&](const PartMotion& motion) {
    const bool good = isUsable(world, motion);
    usable = usable && good;
    return good && !isOwned(motion.part);
  };
  begin();
  const bool many = motions.size() > kManyMoving;
  if (many || world.anyLoose()) {
    world.beginMotions(region);
    near_.clear();
    for (std::size_t i = 0; many && i < motions.size(); ++i) {
      if (!takes(motions[i]) || !world.noteMotion(motions[i].part, motions[i].worldFromPart)) continue;
      if (near_.size() < near_.capacity()) near_.push_back(static_cast<std::uint32_t>(i));
    }
    world.endMotions();
  }
  if (many) {
    for (const std::uint32_t i : near_) {
      const PartMotion& motion = motions[i];
      const Pose before = world.pose(motion.part);
      const Twist twistBefore = world.twist(motion.part);
      world.setNearPose(motion.part, motion.worldFromPart, borneOutTwist(before, motion, dt));
      note(motion.part);
      if (!samePose(before, motion.worldFromPart)) moved(motion, before, twistBefore);
    }
  } else {
    for (const PartMotion& motion : motions) {
      if (!takes(motion)) continue;
      const Twist twist = borneOutTwist(world.pose(motion.part), motion, dt);
      movePart(
          world, motion.part, motion.worldFromPart, twist,
          [&](PartId, const Pose& before, const Twist& twistBefore) { moved(motion, before, twistBefore); });
      note(motion.part);
    }
  }
  stopOthers(world);
  return usable;
}

}  // namespace tandem::haptics
