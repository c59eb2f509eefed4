#include "sync/replica/motion_judge.h"

#include <algorithm>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

constexpr double kPositionSlack = 1.5e-3;          // m: quanta, and what a clock that is corrected may shift
constexpr double kSpeedSlack = 0.5;                // m/s
constexpr Micros kLongGap = 60 * kMillisecond;     // beyond it only the mean speed is judged
constexpr Micros kClockSteps = 20 * kMillisecond;  // by which an honest clock may be set back

}  // namespace

MotionJudge::MotionJudge(std::vector<double> masses) : masses_(std::move(masses)), tracks_(masses_.size()) {}

void MotionJudge::restart() {
  for (Track& track : tracks_) track.known = false;
}

bool MotionJudge::isPossible(const Track& last, const PartState& state, Micros time, double mass) const {
  if (time <= last.time) return last.time - time < kClockSteps;
  const double dt = toSeconds(time - last.time);
  const glm::dvec3 moved = state.worldFromPart.position - last.pose.position;
  const double before = glm::length(last.twist.linear), after = glm::length(state.twist.linear);
  if (glm::length(moved) > kMaxSpeed * dt + kPositionSlack || after > kMaxSpeed) return false;
  if (glm::length(state.twist.angular) > kMaxSpin) return false;
  if (time - last.time > kLongGap) return true;
  // Between the two states the velocity was one of theirs or lay between them, but for a short impact.
  const glm::dvec3 mean = 0.5 * (last.twist.linear + state.twist.linear);
  const double spread = 0.5 * glm::length(state.twist.linear - last.twist.linear) + kSpeedSlack;
  if (glm::length(moved - dt * mean) > dt * spread + kPositionSlack) return false;
  return !(mass > 0.0) || after - before <= (kMaxForce / mass + kMaxAcceleration) * dt + kSpeedSlack;
}

bool MotionJudge::judge(const PartState& state, Micros time, Micros now) {
  ASSERT(state.part < tracks_.size());
  Track& track = tracks_[state.part];
  const bool follows = track.known && track.epoch == state.epoch;
  const bool possible = !follows || isPossible(track, state, time, masses_[state.part]);
  track.known = true;
  track.epoch = state.epoch;
  track.time = time;
  track.pose = state.worldFromPart;
  track.twist = state.twist;
  if (possible) return false;
  ++impossible_;
  const double since = toSeconds(std::max<Micros>(0, now - track.scoredAt));
  track.score = std::max(0.0, track.score - kForgiven * since) + 1.0;
  track.scoredAt = now;
  if (track.score < kConvicting || (track.called && now - track.calledAt < kQuiet)) return false;
  track.called = true;
  track.calledAt = now;
  track.score = 0.0;
  return true;
}

}  // namespace tandem::sync
