#include "sync/replica/play_out.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

constexpr Micros kLongestSegment = 100 * kMillisecond;  // over a longer gap the displacement is unknown
constexpr Micros kFullSpeed = 25 * kMillisecond;        // of an extrapolation; then it slows to a stop
constexpr Micros kLongAgo = std::numeric_limits<Micros>::min() / 4;

constexpr double kBlendRate = 40.0;          // 1/s of a small correction: 0.3 s to the last 1e-4
constexpr double kMaxCorrectionSpeed = 1.0;  // m/s: at most this much is added to the motion by a correction
constexpr double kMaxCorrectionTurn = 6.0;   // rad/s
constexpr double kBlendEnd = 1e-4;           // of the largest offset: from here on it counts as none
constexpr double kRateToEnd = 12.0;          // (1 + x) exp(-x) < kBlendEnd
constexpr double kEuler = 2.718281828459045;

/// Cubic Hermite from 0 with rate v0 to `d` with rate v1 over `span` seconds; value and rate at s in [0, 1].
void hermite(const glm::dvec3& d, const glm::dvec3& v0, const glm::dvec3& v1, double span, double s,
             glm::dvec3& value, glm::dvec3& rate) {
  ASSERT(span > 0.0 && s >= 0.0 && s <= 1.0);
  const double s2 = s * s, s3 = s2 * s;
  value = d * (3.0 * s2 - 2.0 * s3) + v0 * (span * (s3 - 2.0 * s2 + s)) + v1 * (span * (s3 - s2));
  rate = d * ((6.0 * s - 6.0 * s2) / span) + v0 * (3.0 * s2 - 4.0 * s + 1.0) + v1 * (3.0 * s2 - 2.0 * s);
}

/// One step of the critically damped x'' = -2 w x' - w^2 x, by its exact solution.
void dampedStep(glm::dvec3& x, glm::dvec3& v, double w, double dt) {
  ASSERT(w > 0.0 && dt >= 0.0);
  const glm::dvec3 c = v + w * x;
  const double e = std::exp(-w * dt);
  x = (x + c * dt) * e;
  v = c * e - w * x;
}

}  // namespace

// ---- PlayOutDelay ----

void PlayOutDelay::observe(Micros stateTime, Micros arrival) {
  transit_[next_] = std::max<Micros>(0, arrival - stateTime);
  next_ = (next_ + 1) % kWindow;
  count_ = std::min(count_ + 1, kWindow);
  std::array<Micros, kWindow> sorted = transit_;
  // The play-out delay covers the 98 % quantile of the transits; two outliers in a full window are
  // extrapolated.
  const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(count_);
  const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(count_ - 1 - count_ / 64);
  std::nth_element(sorted.begin(), at, end);
  target_us_ = static_cast<double>(*at + kReserve);
  ASSERT(target_us_ >= static_cast<double>(kReserve));
  if (!started_) current_us_ = target_us_;
}

Micros PlayOutDelay::delay(Micros now) {
  if (count_ == 0) return 0;
  if (started_) {
    const auto elapsed = static_cast<double>(std::max<Micros>(0, now - last_));
    current_us_ += std::clamp(target_us_ - current_us_, -0.05 * elapsed, 0.5 * elapsed);
  }
  started_ = true;
  last_ = std::max(last_, now);
  return static_cast<Micros>(current_us_);
}

// ---- PlayOut ----

void PlayOut::restart(const Pose& worldFromPart, Micros now, Micros blend) {
  if (shownBefore_ && now > shownAt_) decay(toSeconds(now - shownAt_));
  entries_[0] = {kLongAgo, worldFromPart, {}};
  count_ = 1;
  if (!shownBefore_ || blend <= 0) {
    offset_ = offsetRate_ = turn_ = turnRate_ = glm::dvec3(0.0);
    blendRate_ = largestOffset_ = largestTurn_ = 0.0;
  } else {
    blendStep(raw_, worldFromPart, kRateToEnd / toSeconds(blend));
    shownAt_ = std::max(shownAt_, now);
  }
  raw_ = worldFromPart;
  changed_ = false;
}

void PlayOut::push(const PartState& state, Micros time) {
  std::size_t at = count_;
  while (at > 0 && entries_[at - 1].time > time) --at;
  if (at > 0 && entries_[at - 1].time == time) return;
  if (count_ == kCapacity) {
    if (at == 0) return;
    std::move(entries_.begin() + 1, entries_.end(), entries_.begin());
    --count_;
    --at;
  }
  const auto from = entries_.begin() + static_cast<std::ptrdiff_t>(at);
  const auto end = entries_.begin() + static_cast<std::ptrdiff_t>(count_);
  std::move_backward(from, end, end + 1);
  entries_[at] = {time, state.worldFromPart, state.twist};
  ++count_;
  ASSERT(count_ <= kCapacity && entries_[at].time == time);
  changed_ = true;
}

PlayOut::Shown PlayOut::sample(Micros t) const {
  if (count_ == 0) return {};
  std::size_t next = count_;
  while (next > 0 && entries_[next - 1].time > t) --next;
  if (next == 0) return {entries_[0].pose, {}, false, false};

  const Entry& a = entries_[next - 1];
  if (next == count_) {
    if (isStill(a.twist)) return {a.pose, {}, false, true};
    const Micros beyond = std::min(t - a.time, kMaxExtrapolation);
    if (beyond == 0) return {a.pose, a.twist, false, false};
    // At full speed first, then the speed falls linearly to none at the bound.
    const double slow = toSeconds(std::max<Micros>(0, beyond - kFullSpeed));
    const double slowing = toSeconds(kMaxExtrapolation - kFullSpeed);
    const double travel = toSeconds(beyond) - slow * slow / (2.0 * slowing);
    const double speed = 1.0 - slow / slowing;
    const bool stopped = beyond == kMaxExtrapolation;
    return {
        integrate(a.pose, a.twist, travel), {a.twist.linear * speed, a.twist.angular * speed}, true, stopped};
  }

  const Entry& b = entries_[next];
  // After a long silence the part stands until shortly before the next state, as it was shown meanwhile.
  const bool silent = a.time < b.time - kLongestSegment;
  const Micros start = silent ? b.time - kLongestSegment : a.time;
  if (t <= start) return {a.pose, silent ? Twist{} : a.twist, false, false};
  const Twist from = silent ? Twist{} : a.twist;
  const double span = toSeconds(b.time - start), s = toSeconds(t - start) / span;
  Shown shown;
  shown.still = false;
  glm::dvec3 moved, turned, turnedRate;
  hermite(b.pose.position - a.pose.position, from.linear, b.twist.linear, span, s, moved, shown.twist.linear);
  shown.worldFromPart.position = a.pose.position + moved;
  // Rotations by the rotation vector r from a; the inverse of its left Jacobian (Sola et al., "A micro Lie
  // theory", eq. 146), to second order, turns b's angular velocity into a rate of r, the Jacobian itself
  // turns it back.
  const glm::dvec3 r = rotationVector(b.pose.orientation * glm::conjugate(a.pose.orientation));
  const glm::dvec3& w = b.twist.angular;
  const glm::dvec3 endRate = w - 0.5 * glm::cross(r, w) + glm::cross(r, glm::cross(r, w)) / 12.0;
  hermite(r, from.angular, endRate, span, s, turned, turnedRate);
  shown.worldFromPart.orientation = glm::normalize(fromRotationVector(turned) * a.pose.orientation);
  shown.twist.angular = turnedRate + 0.5 * glm::cross(turned, turnedRate) +
                        glm::cross(turned, glm::cross(turned, turnedRate)) / 6.0;
  return shown;
}

void PlayOut::blendStep(const Pose& from, const Pose& to, double rate) {
  const glm::dvec3 step = from.position - to.position;
  const glm::dvec3 turnStep = rotationVector(from.orientation * glm::conjugate(to.orientation));
  if (step == glm::dvec3(0.0) && glm::dot(turnStep, turnStep) < 1e-24) return;
  offset_ += step;
  turn_ = rotationVector(fromRotationVector(turn_) * fromRotationVector(turnStep));
  const double length = glm::length(offset_), angle = glm::length(turn_);
  if (rate <= 0.0) {
    // A critically damped offset that starts at rest reaches its greatest speed, w |offset| / e, at t = 1/w.
    rate = kBlendRate;
    if (length > 0.0) rate = std::min(rate, kEuler * kMaxCorrectionSpeed / length);
    if (angle > 0.0) rate = std::min(rate, kEuler * kMaxCorrectionTurn / angle);
  }
  ASSERT(rate > 0.0);
  blendRate_ = rate;
  largestOffset_ = std::max(largestOffset_, length);
  largestTurn_ = std::max(largestTurn_, angle);
}

void PlayOut::decay(double dt) {
  if (blendRate_ <= 0.0) return;
  dampedStep(offset_, offsetRate_, blendRate_, dt);
  dampedStep(turn_, turnRate_, blendRate_, dt);
  // Both rates must be small too: an offset that passes through zero has not ended.
  const double length = glm::length(offset_) + glm::length(offsetRate_) / blendRate_;
  const double angle = glm::length(turn_) + glm::length(turnRate_) / blendRate_;
  if (length > 2.0 * kRateToEnd * kBlendEnd * largestOffset_ ||
      angle > 2.0 * kRateToEnd * kBlendEnd * largestTurn_) {
    return;
  }
  offset_ = offsetRate_ = turn_ = turnRate_ = glm::dvec3(0.0);
  blendRate_ = largestOffset_ = largestTurn_ = 0.0;
}

PlayOut::Shown PlayOut::at(Micros now, Micros delay) {
  const Micros t = now - delay;
  if (shownBefore_) {
    decay(toSeconds(std::max<Micros>(0, now - shownAt_)));
    // States that have arrived since may change the pose at the instant that was shown last. That step is
    // blended.
    if (changed_) blendStep(raw_, sample(playedAt_).worldFromPart, 0.0);
  }
  Shown shown = sample(t);
  raw_ = shown.worldFromPart;
  if (blendRate_ > 0.0) {
    shown.worldFromPart.position += offset_;
    shown.worldFromPart.orientation =
        glm::normalize(fromRotationVector(turn_) * shown.worldFromPart.orientation);
    shown.twist.linear += offsetRate_;
    shown.twist.angular += turnRate_;
    shown.still = false;
  }
  shownBefore_ = true;
  changed_ = false;
  shownAt_ = now;
  playedAt_ = t;
  return shown;
}

}  // namespace tandem::sync
