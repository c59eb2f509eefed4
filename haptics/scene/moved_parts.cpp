#include "haptics/scene/moved_parts.h"

#include <algorithm>
#include <cmath>

namespace tandem::haptics {

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
