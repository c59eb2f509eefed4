#pragma once

// Regime of a link by the age of its newest packet.

#include "haptics/base/link_packet.h"

namespace tandem::haptics {

class RegimeByAge {
 public:
  /// `farthest` s is the age beyond which the link is off.
  explicit RegimeByAge(double farthest = kFarthest) : farthest_(farthest) {}

  /// Takes effect with the next advance().
  void setFarthest(double farthest) { farthest_ = farthest; }

  /// Restarts with a network delay of `delay` s that is known from elsewhere.
  void restart(double delay);

  /// Advances by dt (s): `age` (s) is that of the newest packet, `peers` the regime that the other end
  /// measures. Returns whether the regime changed. The regime worsens at once and improves after kProof; the
  /// worse of both ends counts, so that both agree.
  bool advance(double age, LinkRegime peers, double dt);

  /// Takes the present age as the long-term one, because the link restarts in any case.
  void beginAnew() { slowAge_ = age_; }

  LinkRegime regime() const { return regime_; }
  /// The regime of this end's path alone.
  LinkRegime measured() const { return measured_; }
  /// Age of the newest packet, low-passed, s.
  double age() const { return age_; }

 private:
  static constexpr double kFarthest = 0.15;
  LinkRegime wanted(double age) const;

  double farthest_;       // s
  double age_ = 0.0;      // s
  double slowAge_ = 0.0;  // s: long-term age, which jitter does not raise
  double better_ = 0.0;   // s, for which a better regime has been due
  LinkRegime measured_ = LinkRegime::apart, regime_ = LinkRegime::apart;
};

}  // namespace tandem::haptics
