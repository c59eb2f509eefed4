#include "haptics/moved_parts.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

// Below these, a velocity does no harm that the poses do not bear out.
constexpr double kLeastSpeed = 5e-3;    // m/s
constexpr double kLeastTurning = 0.05;  // rad/s

}  // namespace

MovedParts::MovedParts(std::size_t parts) {
  near_.reserve(parts);
  moving_.reserve(std::max(parts, kManyMoving));
  movedBefore_.reserve(std::max(parts, kManyMoving));
  movedAt_.resize(parts);
}

bool MovedParts::isUsable(const ContactWorld& world, const PartMotion& motion) {
  const glm::dvec3 &p = motion.worldFromPart.position, &v = motion.twist.linear, &w = motion.twist.angular;
  const glm::dquat& q = motion.worldFromPart.orientation;
  const double sum = p.x + p.y + p.z + v.x + v.y + v.z + w.x + w.y + w.z;
  const double norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return world.has(motion.part) && sum - sum == 0.0 && std::abs(norm - 1.0) < 2e-6;
}

Twist borneOutTwist(const Pose& before, const PartMotion& motion, double dt) {
  if (!(dt > 0.0)) return motion.twist;
  const Pose& now = motion.worldFromPart;
  const Twist shown{(now.position - before.position) / dt,
                    rotationVector(now.orientation * glm::conjugate(before.orientation)) / dt};
  // A part that begins or ends its motion within the tick has gone half as far as its velocity says.
  const auto bears = [](const glm::dvec3& said, const glm::dvec3& seen, double least) {
    return glm::length(said - seen) <= least + glm::length(seen);
  };
  const Twist& said = motion.twist;
  return {bears(said.linear, shown.linear, kLeastSpeed) ? said.linear : shown.linear,
          bears(said.angular, shown.angular, kLeastTurning) ? said.angular : shown.angular};
}

void MovedParts::begin() {
  // The twists of the last tick stay until each part has moved: they distinguish a motion from a jump.
  std::swap(moving_, movedBefore_);
  moving_.clear();
  ++tickNumber_;
}

void MovedParts::note(PartId part) {
  moving_.push_back(part);
  movedAt_[part] = tickNumber_;
}

void MovedParts::stopOthers(ContactWorld& world) const {
  for (const PartId part : movedBefore_) {
    if (movedAt_[part] != tickNumber_) world.setTwist(part, Twist{});
  }
}

}  // namespace tandem::haptics
