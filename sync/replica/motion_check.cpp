#include "sync/replica/motion_check.h"

#include <algorithm>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace tandem::sync {
namespace {

// Above this a turn between two states may have gone round.
constexpr double kMostTurn = 2.5;  // rad

/// Adds to a sum what happened in dt s; true if it passes its limit.
bool add(double& sum, double what, double dt, const MotionSum& limit) {
  sum = std::max(0.0, sum - limit.shrinks * dt) + std::max(0.0, what);
  return sum > limit.most;
}

}  // namespace

bool MotionCheck::observe(const PartState& state, const glm::dvec3& centre, Micros time,
                          const MotionLimits& limits) {
  const Pose& part = state.worldFromPart;
  const Pose now{transformPoint(part, centre), part.orientation};
  const Twist twist{velocityAt(part, state.twist, now.position), state.twist.angular};
  const Pose before = std::exchange(worldFromCentre_, now);
  const Twist twistBefore = std::exchange(twist_, twist);
  const Micros elapsed = std::max<Micros>(0, time - std::exchange(time_, time));
  const bool sameEpoch = std::exchange(epoch_, state.epoch) == state.epoch;
  if (!std::exchange(known_, true) || !sameEpoch || elapsed > kLongest) return false;
  const double dt = toSeconds(elapsed), quarter = 0.25 * dt * dt;
  const glm::dvec3 way = now.position - before.position;
  const glm::dvec3 saidWay = 0.5 * dt * (twistBefore.linear + twist.linear);
  const glm::dvec3 turn = rotationVector(now.orientation * glm::conjugate(before.orientation));
  const glm::dvec3 saidTurn = 0.5 * dt * (twistBefore.angular + twist.angular);
  const bool clear = glm::length(saidTurn) + limits.unseenTurn * quarter < kMostTurn;
  const double strayed = glm::length(way - saidWay) - limits.unseen * quarter;
  const double turned = clear ? glm::length(turn - saidTurn) - limits.unseenTurn * quarter : 0.0;
  bool beyond = add(way_, strayed, dt, limits.way);
  beyond = add(turn_, turned, dt, limits.turn) || beyond;
  beyond = add(change_, glm::length(twist.linear - twistBefore.linear), dt, limits.change) || beyond;
  beyond = add(spin_, glm::length(twist.angular - twistBefore.angular), dt, limits.spin) || beyond;
  if (beyond) way_ = turn_ = change_ = spin_ = 0.0;
  return beyond;
}

}  // namespace tandem::sync
