#pragma once

// Decides when the replica of a part that another site holds becomes dynamic: before the two parts touch. A
// kinematic replica in contact at both sites creates energy, and a link requested at contact comes too late.

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/pose.h"

namespace tandem::haptics {

/// The co-holder's side: it requests the link, follows the owner until it sees the owner's end on, and then
/// becomes dynamic.
class LinkEngagement {
 public:
  enum class Role { follower, coHolder };

  /// Advances by dt (s). `gap` (m) and `closing` (m/s) are to the parts that this site holds, `playOutDelay`
  /// (s) is that of the link, `ownerOn` says that the owner's end is known to be on, and `force` (N) is the
  /// link's force on the replica.
  Role advance(double gap, double closing, double playOutDelay, bool ownerOn, double force, double dt) {
    // The gap must cover the approach while request and answer travel and the link fades in.
    const bool wants = gap < kNear + std::max(0.0, closing) * (2.0 * playOutDelay + kFadeTime);
    idle_ = wants ? 0.0 : idle_ + dt;
    if (wants) asks_ = true;
    if (idle_ > kPatience && gap > kNear + kMargin) asks_ = false;
    if (role_ == Role::follower && asks_ && ownerOn) role_ = Role::coHolder;
    if (role_ == Role::coHolder && !asks_ && force < kForceLeft) role_ = Role::follower;
    return role_;
  }

  Role role() const { return role_; }
  bool asks() const { return asks_; }

  static constexpr double kFadeTime = 0.3;  // s, of such a link

 private:
  static constexpr double kNear = 0.03, kMargin = 0.01;  // m
  static constexpr double kPatience = 0.5;               // s
  static constexpr double kForceLeft = 0.01;             // N

  Role role_ = Role::follower;
  bool asks_ = false;
  double idle_ = 0.0;  // s, since the link was last needed
};

/// Velocity at which a follower approaches the present pose of the owner's part; the gap it reacts to is
/// limited.
inline Twist followTwist(const Pose& from, const Pose& target, const Twist& targetTwist) {
  constexpr double kTime = 0.03, kMaxGap = 0.01, kMaxRotation = 0.2;  // s, m, rad
  const auto within = [](const glm::dvec3& v, double limit) {
    const double size = glm::length(v);
    return size > limit ? v * (limit / size) : v;
  };
  const glm::dvec3 rotation = rotationVector(target.orientation * glm::conjugate(from.orientation));
  return {targetTwist.linear + within(target.position - from.position, kMaxGap) / kTime,
          targetTwist.angular + within(rotation, kMaxRotation) / kTime};
}

}  // namespace tandem::haptics
