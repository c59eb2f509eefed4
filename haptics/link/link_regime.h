#pragma once

// What a link may do, by the age of what it hears last.

#include "haptics/base/link_packet.h"

namespace tandem::haptics {

class RegimeByAge {
 public:
  /// `farthest` s: the age beyond which there is no link.
  explicit RegimeByAge(double farthest = kFarthest) : farthest_(farthest) {}

  /// From the next advance() on.
  void setFarthest(double farthest) { farthest_ = farthest; }

  /// Begins with a way of `delay` s, as it is known from elsewhere.
  void restart(double delay);

  /// Advances by dt (s): `age` (s) is that of the newest packet, `peers` what the other end measures. Returns whether
  /// the regime changed. Worse at once, better after kProof; the worse of both ends counts, so that both agree.
  bool advance(double age, LinkRegime peers, double dt);

  /// The link begins anew in any case: the age as it is now counts, however short it has been so.
  void beginAnew() { slowAge_ = age_; }

  LinkRegime regime() const { return regime_; }
  /// Of this end's way alone.
  LinkRegime measured() const { return measured_; }
  /// Age of the newest packet, low-passed, s.
  double age() const { return age_; }

 private:
  static constexpr double kFarthest = 0.15;
  LinkRegime wanted(double age) const;

  double farthest_;       // s
  double age_ = 0.0;      // s
  double slowAge_ = 0.0;  // s: jitter does not make a way soft
  double better_ = 0.0;   // s, for which a better regime was due
  LinkRegime measured_ = LinkRegime::apart, regime_ = LinkRegime::apart;
};

}  // namespace tandem::haptics
