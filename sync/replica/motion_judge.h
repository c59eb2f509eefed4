#pragma once

// Judges whether the states that a site publishes of its parts are motions that a hand can give a body of
// that mass. It changes nothing: it counts, and tells which site has claimed the impossible for a while.
//
// A state is impossible if it does not follow its predecessor in time, if the part would have been faster
// than kMaxSpeed or kMaxSpin, if its displacement contradicts both of its velocities, or if it gained speed
// faster than kMaxForce accelerates its mass. A stop, or a turn of the velocity at the same speed, is
// possible at any rate: a part may hit something. Losses lengthen the interval, which makes the judgement
// milder.
//
// A score for each part tells a liar from an accident: an impossible state adds one, and it loses kForgiven a
// second. At kConvicting the part's motion is called impossible, once in every kQuiet.
//
// Allocates in the constructor only.

#include <cstddef>
#include <vector>

#include "sync/wire/state_update.h"
#include "sync/wire/time.h"

namespace tandem::sync {

class MotionJudge {
 public:
  static constexpr double kMaxSpeed = 7.0;          // m/s, of a hand; the wire holds no more than 8 an axis
  static constexpr double kMaxSpin = 60.0;          // rad/s
  static constexpr double kMaxForce = 60.0;         // N, on a part, by all who hold it
  static constexpr double kMaxAcceleration = 60.0;  // m/s^2, besides: gravity, and parts as light as a hand
  static constexpr double kForgiven = 4.0;          // points a second
  static constexpr double kConvicting = 20.0;       // points
  static constexpr Micros kQuiet = 10 * kSecond;

  /// Masses of the parts, kg, by part; without a mass (<= 0) only speeds are judged.
  explicit MotionJudge(std::vector<double> masses);

  /// An accepted state, holding at `time`, came at `now`. True when its part's motion is to be called
  /// impossible.
  [[nodiscard]] bool judge(const PartState& state, Micros time, Micros now);
  /// The states begin anew, as on a new connection: what comes first is no motion.
  void restart();

  /// Impossible states so far.
  std::uint64_t impossible() const { return impossible_; }

 private:
  struct Track {
    bool known = false;
    Epoch epoch = 0;
    Micros time = 0;
    Pose pose;
    Twist twist;
    double score = 0.0;
    Micros scoredAt = 0, calledAt = 0;
    bool called = false;
  };
  bool isPossible(const Track& last, const PartState& state, Micros time, double mass) const;

  std::vector<double> masses_;
  std::vector<Track> tracks_;
  std::uint64_t impossible_ = 0;
};

}  // namespace tandem::sync
