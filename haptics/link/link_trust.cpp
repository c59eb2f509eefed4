#include "haptics/link/link_trust.h"

#include <algorithm>
#include <cmath>

namespace tandem::haptics {

void LinkTrust::advance(const SixAxes& velocity, double dt) {
  // A velocity grows with the lever as a force shrinks.
  const double speed = length(atPartsLever(velocity));
  speed_ = std::max(speed, speed_ * (1.0 - dt / kLately));
  const double more = ((held_ ? 1.0 : kNear) * slew_ + kBySpeed * speed_) * dt;
  allowance_ = std::min(std::max(kBurst, more), allowance_ + more);
  ahead_ *= std::max(0.0, 1.0 - dt / kForgetting);
  contradictions_ *= std::max(0.0, 1.0 - dt / kForgetting);
  doubtFor_ = std::max(0.0, doubtFor_ - dt);
}

// The force may take over any share of the own change: a peer who goes along has taken it away again.
SixAxes LinkTrust::admit(const SixAxes& said, const SixAxes& own, double dt) {
  if (!limits()) return said;
  const SixAxes asked = atLongerLever(said), change = atLongerLever(own);
  const double square = dot(change, change);
  const double share = square > 0.0 ? std::clamp(dot(asked - force_, change) / square, 0.0, 1.0) : 0.0;
  const SixAxes nearest = force_ + share * change;
  const SixAxes step = shortened(asked - nearest, allowance_);
  force_ = nearest + step;
  allowance_ -= length(step);
  const SixAxes ahead = asked - force_;
  const double push = glm::length(ahead.along) / kPush, twist = glm::length(ahead.about) / kTwist;
  ahead_ += dt * (push * push + twist * twist) * kPush;
  if (ahead_ > kMostAhead) doubt();
  return atPartsLever(force_);
}

void LinkTrust::contradicted() {
  if (limits() && (contradictions_ += 1.0) > kMostContradictions) doubt();
}

void LinkTrust::doubt() {
  if (doubts()) return;
  doubtFor_ = std::min(kLongest, std::ldexp(kDoubt, std::min(times_, 8)));
  ++times_;
  isNew_ = true;
  ahead_ = contradictions_ = 0.0;
}

}  // namespace tandem::haptics
