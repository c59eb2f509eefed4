#include "haptics/body/fade.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {

void Fading::start(const glm::dvec3& ended, double stiffness) {
  from_ = now() + ended;
  if (stiffness > 0.0) left_ += 0.5 * glm::dot(ended, ended) / stiffness;
  full_ = left_;
  share_ = 1.0;
}

void Fading::advance(const glm::dvec3& displacement, double timeShare) {
  left_ = std::max(0.0, left_ - glm::dot(now(), displacement));
  // The force of a spring is proportional to the square root of its energy.
  share_ = full_ > 0.0 ? std::min(timeShare, std::sqrt(left_ / full_)) : 0.0;
  left_ = std::min(left_, share_ * share_ * full_);
}

void Fade::start(const Wrench& ended, const Stiffness& stiffness, double time) {
  force_.start(ended.force, stiffness.linear);
  torque_.start(ended.torque, stiffness.angular);
  left_ = total_ = time;
}

void Fade::advance(const glm::dvec3& displacement, const glm::dvec3& rotation, double dt) {
  left_ = left_ > dt ? left_ - dt : 0.0;
  const double share = total_ > 0.0 ? left_ / total_ : 0.0;
  force_.advance(displacement, share);
  torque_.advance(rotation, share);
}

}  // namespace tandem::haptics
