#pragma once

// Bookkeeping of the servo loop, separate from clock and thread so that tests run it on virtual times.

#include <cstdint>

#include "haptics/base/contact_effort.h"

namespace tandem::haptics {

/// Wake-up times. Deadlines stay on the grid start + n * period; periods that have already passed are
/// skipped.
class ServoSchedule {
 public:
  ServoSchedule(std::int64_t start_ns, std::int64_t period_ns);

  std::int64_t deadline_ns() const { return deadline_ns_; }

  /// Notes a wake-up at `woken_ns` for the present deadline; true when it is more than half a period late.
  bool woke(std::int64_t woken_ns) const { return woken_ns - deadline_ns_ > period_ns_ / 2; }

  /// Moves to the next deadline after `done_ns`, the end of the tick's work; returns the number of skipped
  /// periods.
  std::int64_t advance(std::int64_t done_ns);

 private:
  std::int64_t period_ns_;
  std::int64_t deadline_ns_;
};

/// Detects a callback that overruns its budget too often: it trips at kLimit overruns within the last kWindow
/// ticks, and clears after kWindow consecutive ticks without one.
class OverrunGuard {
 public:
  static constexpr int kWindow = 64;
  static constexpr int kLimit = 16;

  /// Notes a tick; true while the force must be zero.
  bool note(bool overran);
  bool tripped() const { return tripped_; }

 private:
  std::uint64_t history_ = 0;  // bit i: i ticks ago
  bool tripped_ = false;
};

/// Lowers the effort of contact between parts while ticks are short of time, in stages: half the sample
/// queries and no descents from samples, a quarter of the queries and two steps, an eighth and one step.
/// Parts then move less far in a tick; contacts stay exact at the samples. The effort returns stage by stage
/// once ticks have been fast for kCalm of them.
class EffortGuard {
 public:
  static constexpr int kWindow = 64, kLimit = 6, kCalm = 1000, kMaxStages = 3;
  static constexpr double kShort = 0.7, kEasy = 0.35;  // of a period

  /// Notes the fraction of its period that a tick took.
  void note(double share);
  /// Fraction of the configured effort that the next tick may use.
  ContactEffort limited(ContactEffort set) const;
  int stage() const { return stage_; }

 private:
  std::uint64_t history_ = 0;  // bit i: i ticks ago
  int stage_ = 0, calm_ = 0;
};

}  // namespace tandem::haptics
