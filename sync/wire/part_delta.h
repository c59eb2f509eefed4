#pragma once

// One part's state as the difference to what a baseline, an earlier state that the receiver has, predicts by
// its velocity. The difference is sent exactly. Only the encoders of state datagrams include this.
//
// The prediction. Velocities v are taken to go on as they were, or to go on changing as they did up to the
// baseline; the new one then says by how much that was wrong. Position and orientation follow from the
// velocities before, at and after the baseline, by the integral of the polynomial through them: the trapezoid
// rule, or with three of them the Adams-Moulton rule of third order (Hairer, Norsett, Wanner, "Solving ODEs
// I", III.1) for uneven steps. A hand's motion is smooth: of 50 ms at 0.3 m/s some 15 mm are predicted to
// within 0.1 mm.
//
// 1. Lossless: the decoded code is the encoded one, whatever was predicted.
// 2. Both ends predict the same bits: only + - * / sqrt and rounding to whole numbers, which IEEE 754 fixes
//    (with -ffp-contract=off), and no function of a library that two machines may have in two versions.

#include "sync/wire/state_code.h"

namespace tandem::sync {

/// How large the differences were, as orders of Exp-Golomb codes: linear and angular velocity, position,
/// orientation. A state may inherit the orders of its baseline, which then cost nothing.
using DeltaOrders = std::array<int, 4>;

/// A part as a datagram carried it.
struct PartBaseline {
  PartCode code;
  bool hasBefore = false;  // that datagram had itself a baseline, which the rest describes
  TwistCode before;        // the velocity of that baseline
  Micros sinceBefore = 0;  // > 0
  DeltaOrders orders{};
};

/// Longest time from a baseline to a state that is encoded against it.
inline constexpr int kElapsedBits = 22;
inline constexpr Micros kLongestElapsed = (Micros{1} << kElapsedBits) - 1;

/// Appends `now`, `elapsed` after the baseline. Part, epoch and sequence are the caller's to write.
DeltaOrders putDelta(BitWriter& writer, const PartBaseline& baseline, Micros elapsed, const PartCode& now,
                     const WireFrame& frame);
int deltaBits(const PartBaseline& baseline, Micros elapsed, const PartCode& now, const WireFrame& frame);
/// Reads the pose and twist of `now`. The reader fails if they are out of range.
DeltaOrders getDelta(BitReader& reader, const PartBaseline& baseline, Micros elapsed, const WireFrame& frame,
                     PartCode& now);

/// The baseline that `now`, encoded against `baseline`, is for later states.
PartBaseline toldAgainst(const PartBaseline& baseline, Micros elapsed, const PartCode& now,
                         const DeltaOrders& orders);

}  // namespace tandem::sync
