#pragma once

// How far an end of a link believes its peer. Packets may hold any numbers; forces that hands and parts can
// cause reach the hand unchanged.
//
// 1. The force of a link changes by `slew` at most, and kBurst at once, beyond what this replica's own change
//    of velocity does to it: a peer who goes along with this replica cancels that change, and a peer who
//    leads it causes it. Where the replica moves, which no lie makes it do soon, it may change faster. A part
//    that no hand here holds may touch one in a hand: its links change kNear times as fast.
// 2. A peer whose waves run far ahead of what is let in, or often contradict themselves, is not believed: the
//    end acts as if the peer were silent, and the others are told who it is. After kDoubt it is heard again,
//    then after twice as long each time. More than a hand's force counts more, less counts less: a hand that
//    strikes, or turns quickly, is ahead by that much for a moment. A lie of no more than a strong hand's is
//    taken for one.
// 3. A torque counts as the force at the end of the part's lever, but of kLeastLever at least: a hand turns a
//    small part as hard as a larger one.
// 4. Limiting creates no energy: what is let in of a wave is accounted for like any wave
//    (CoordinationLink::pay).
// 5. Nothing here allocates. The thread that ticks uses it.

#include <algorithm>
#include <utility>

#include "haptics/base/six_axes.h"

namespace tandem::haptics {

class LinkTrust {
 public:
  static constexpr double kMostAhead = 1.0;               // N·s: honest peers, 0.65
  static constexpr double kDoubt = 4.0, kLongest = 64.0;  // s

  /// `slew` N/s; 0: the peer is believed. `lever` m, that of the link's six axes.
  LinkTrust(double slew, double lever) : slew_(slew), shorter_(std::min(1.0, lever / kLeastLever)) {}

  /// Whether a hand here holds the part.
  void setHeld(bool held) { held_ = held; }
  bool held() const { return held_; }
  bool limits() const { return slew_ > 0.0; }

  /// Begins a tick of dt s, in which the replica moves with this velocity, m/s.
  void advance(const SixAxes& velocity, double dt);
  /// What counts of the force that the peer's wave makes, N, where this replica's own motion has changed the
  /// force by `own` since the last tick.
  SixAxes admit(const SixAxes& said, const SixAxes& own, double dt);
  /// The next force is bridged: it counts as it is.
  void beginAnew(const SixAxes& force) { force_ = atLongerLever(force); }
  /// A packet contradicts the order of those before it, in time, energy or fade.
  void contradicted();

  /// Whether the peer is not believed now.
  bool doubts() const { return doubtFor_ > 0.0; }
  /// Whether it has come to that since the last call.
  bool drainDoubt() { return std::exchange(isNew_, false); }

 private:
  static constexpr double kForgetting = 0.3;   // s
  static constexpr double kLeastLever = 0.06;  // m
  // Of a hand, ahead. What is ahead is weighted by its share of these.
  static constexpr double kPush = 4.0;    // N
  static constexpr double kTwist = 12.0;  // N at the lever: 0.7 N·m on a small part, a flick of the wrist
  static constexpr double kMostContradictions = 12.0;
  static constexpr double kBySpeed = 100.0;  // N/s for each m/s
  static constexpr double kNear = 4.0;       // of `slew`: with less, honest contact is felt later
  static constexpr double kLately = 0.1;     // s
  static constexpr double kBurst = 0.05;     // N: late packets make honest forces jump by less

  /// The same force and torque in axes of the lever that counts here, and back.
  SixAxes atLongerLever(const SixAxes& force) const { return {force.along, shorter_ * force.about}; }
  SixAxes atPartsLever(const SixAxes& force) const { return {force.along, (1.0 / shorter_) * force.about}; }
  void doubt();

  double slew_;
  double shorter_;  // the part's lever as a share of the one that counts here, 0..1
  bool held_ = false;
  SixAxes force_;                // N: what counted in the last tick
  double speed_ = 0.0;           // m/s, the most of it lately
  double allowance_ = 0.0;       // N, by which the force may change at once
  double ahead_ = 0.0;           // N·s, lately, weighted
  double contradictions_ = 0.0;  // lately
  double doubtFor_ = 0.0;        // s
  int times_ = 0;
  bool isNew_ = false;
};

}  // namespace tandem::haptics
