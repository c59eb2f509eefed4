#pragma once

// How far behind its peer an end plays out: as little as keeps the wave from running dry.

#include <algorithm>

namespace tandem::haptics {

/// Follows a high quantile of the age of the newest packet, kEnough of all ticks being fresh: an age above lets it grow
/// by kStep, any other shrink by kStep (1 - kEnough) (Robbins & Monro 1951). The play-out time is stretched by less than
/// half that way, never set back. An age far above is an outage, no jitter, and counts for nothing. What is played out is
/// `margin` s later than that, or earlier: sooner at hand, and oftener dry.
class PlayOutDelay {
 public:
  explicit PlayOutDelay(double margin = 0.0) : margin_(margin) {}

  static constexpr double kOutage = 0.02;  // s without a fresh packet: more than three in a row are lost

  /// Begins with `age` (s) as the mean age of the newest packet, for packets every `packetPeriod` s and ticks of `dt` s.
  void restart(double age, double packetPeriod, double dt) {
    seconds_ = 1.15 * age + packetPeriod + 2.0 * dt;
  }

  /// A tick in which the newest packet is `age` s old.
  void advance(double age) {
    if (age > seconds_ + kOutage) return;
    seconds_ += kStep * ((age >= seconds_ ? 1.0 : 0.0) - (1.0 - kEnough));
  }

  /// A gap of packets is over in which the newest one became `age` s old: the next one like it is to be bridged, unless it
  /// was too long for that.
  void lengthen(double age) {
    if (age < seconds_ + kMostBridged) seconds_ = std::max(seconds_, age);
  }

  double seconds() const { return seconds_ + margin_; }

 private:
  static constexpr double kEnough = 0.998;
  static constexpr double kStep = 0.5e-3;       // s
  static constexpr double kMostBridged = 0.04;  // s

  double margin_;         // s
  double seconds_ = 0.0;  // less the margin
};

}  // namespace tandem::haptics
