#pragma once

// Regime of a link by the age of its newest packet: the filters and the proof around regimeAt()
// (link_distance.h).

#include "haptics/link/link_distance.h"

namespace tandem::haptics {

class RegimeByAge {
 public:
  /// `longest` s is the age beyond which the link is off.
  explicit RegimeByAge(double longest = longestDelay(true)) : longestDelay_(longest) {}

  /// Takes effect with the next advance().
  void setLongestDelay(double longest) { longestDelay_ = longest; }

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
  double longestDelay_;   // s
  double age_ = 0.0;      // s
  double slowAge_ = 0.0;  // s: long-term age, which jitter does not raise
  double better_ = 0.0;   // s, for which a better regime has been due
  LinkRegime measured_ = LinkRegime::apart, regime_ = LinkRegime::apart;
};

}  // namespace tandem::haptics
