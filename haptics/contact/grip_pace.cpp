#include "haptics/contact/grip_pace.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

/// The largest share, 0..1, of `way` whose end is within `radius` + `more` m of a place, or within `more` of
/// the least distance of any share.
double shareWithin(const glm::dvec3& place, const glm::dvec3& way, double radius, double more) {
  const double length = glm::length(way);
  if (!(length > 0.0)) return 1.0;
  const double along = glm::dot(place, way) / length;
  const double across = glm::length(place - along * way / length);
  const double least = std::hypot(across, along - std::clamp(along, 0.0, length));
  const double within = std::max(least, radius) + more;
  const double end = along + std::sqrt(std::max(0.0, within * within - across * across));
  return std::clamp(end / length, 0.0, 1.0);
}

}  // namespace

GripPace paceOf(const GripMotion& motion, double force) {
  GripPace pace;
  if (!(motion.stiffness > 0.0)) {
    pace.aside = pace.farthest = std::numeric_limits<double>::infinity();
    return pace;
  }
  const double way = force / motion.stiffness;
  pace.arm = motion.arm;
  pace.steady = (motion.lastOnHand + motion.spring) / motion.stiffness;
  // A part that stands still while its hand moves on is handWay from the steady place. The radius is larger
  // than that, so that such a part may still move across the hand's way.
  pace.aside = std::max(way, std::hypot(way / 3.0, motion.handWay));
  pace.farthest = std::max(motion.gripWay, motion.handWay + way);
  return pace;
}

double shareWithin(const GripPace& pace, const Displacement& done, const Displacement& next, double pushed) {
  const auto atGrip = [&](const Displacement& u) { return u.linear + glm::cross(u.angular, pace.arm); };
  const glm::dvec3 gone = atGrip(done), way = atGrip(next);
  return std::min(shareWithin(-gone, way, pace.farthest, pushed),
                  shareWithin(pace.steady - gone, way, pace.aside, pushed));
}

}  // namespace tandem::haptics
