#pragma once

// One part's state as the difference to a prediction from a baseline, which is an earlier state that the
// receiver has. The difference is sent exactly. Only the encoders of state datagrams include this.
//
// The prediction. The velocity v is predicted as constant, or as changing at the rate that it had up to the
// baseline; the datagram carries the difference to that. Position and orientation follow from the velocities
// before, at and after the baseline, by the integral of the polynomial through them: the trapezoid rule, or
// with three of them the Adams-Moulton rule of third order (Hairer, Norsett, Wanner, "Solving ODEs I", III.1)
// for uneven steps. A hand's motion is smooth: over 50 ms at 0.3 m/s, 15 mm are predicted to within 0.1 mm.
//
// 1. Lossless: the decoded code is the encoded one, whatever was predicted.
// 2. Both ends predict the same bits: only + - * / sqrt and rounding to whole numbers, which IEEE 754 fixes
//    (with -ffp-contract=off), and no function of a library that two machines may have in two versions.

#include "sync/wire/state_code.h"

namespace tandem::sync {

/// Orders of the Exp-Golomb codes of the four differences: linear and angular velocity, position,
/// orientation. A state may inherit the orders of its baseline, which then cost nothing.
using DeltaOrders = std::array<int, 4>;

/// A part as a datagram carried it.
struct PartBaseline {
  PartCode code;
  bool hasBefore = false;  // it was itself encoded against a baseline, described by the rest
  TwistCode before;        // the velocity of that baseline
  Micros sinceBefore = 0;  // > 0
  DeltaOrders orders{};
};

/// Longest time from a baseline to a state that is encoded against it.
inline constexpr int kElapsedBits = 22;
inline constexpr Micros kLongestElapsed = (Micros{1} << kElapsedBits) - 1;

/// Appends the state `now`, which holds `elapsed` after the baseline. The caller writes part, epoch and
/// sequence.
DeltaOrders putDelta(BitWriter& writer, const PartBaseline& baseline, Micros elapsed, const PartCode& now,
                     const WireFrame& frame);
int deltaBits(const PartBaseline& baseline, Micros elapsed, const PartCode& now, const WireFrame& frame);
/// Reads the pose and twist of `now`. The reader fails if they are out of range.
DeltaOrders getDelta(BitReader& reader, const PartBaseline& baseline, Micros elapsed, const WireFrame& frame,
                     PartCode& now);

/// The baseline that the state `now`, encoded against `baseline`, becomes for later states.
PartBaseline encodedAgainst(const PartBaseline& baseline, Micros elapsed, const PartCode& now,
                            const DeltaOrders& orders);

}  // namespace tandem::sync
