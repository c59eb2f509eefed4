#pragma once

// Play-out delay of a link end: the shortest that keeps the wave from starving.

#include <algorithm>

namespace tandem::haptics {

/// Estimates a high quantile of the age of the newest packet, such that the share kEnough of all ticks is
/// fresh. An age above the estimate raises it by kStep, any other lowers it by kStep (1 - kEnough)
/// (stochastic approximation, Robbins & Monro 1951). The play-out time is stretched by less than half, never
/// set back. An age far above the estimate is an outage rather than jitter and is ignored. `margin` s is
/// added to the estimate; a negative margin plays out sooner and starves more often.
class PlayOutDelay {
 public:
  explicit PlayOutDelay(double margin = 0.0) : margin_(margin) {}

  static constexpr double kOutage = 0.02;  // s without a fresh packet: more than three in a row are lost

  /// Restarts with `age` (s) as the mean age of the newest packet, for packets every `packetPeriod` s and
  /// ticks of `dt` s.
  void restart(double age, double packetPeriod, double dt) {
    seconds_ = 1.15 * age + packetPeriod + 2.0 * dt;
  }

  /// Advances by a tick in which the newest packet is `age` s old.
  void advance(double age) {
    if (age > seconds_ + kOutage) return;
    seconds_ += kStep * ((age >= seconds_ ? 1.0 : 0.0) - (1.0 - kEnough));
  }

  /// Ends a gap in which the newest packet became `age` s old. The delay grows to bridge the next gap like
  /// it, unless the gap was too long.
  void lengthen(double age) {
    if (age < seconds_ + kMaxBridged) seconds_ = std::max(seconds_, age);
  }

  double seconds() const { return seconds_ + margin_; }

 private:
  static constexpr double kEnough = 0.998;
  static constexpr double kStep = 0.5e-3;      // s
  static constexpr double kMaxBridged = 0.04;  // s

  double margin_;         // s
  double seconds_ = 0.0;  // without the margin
};

}  // namespace tandem::haptics
