#include "haptics/link/link_regime.h"

#include <algorithm>

namespace tandem::haptics {
namespace {

constexpr double kFilterTime = 0.1, kLongTerm = 1.0;  // s
constexpr double kProof = 0.5;                        // s: a flapping link stays in the worse regime

}  // namespace

void RegimeByAge::restart(double delay) {
  age_ = slowAge_ = delay;
  better_ = 0.0;
  measured_ = regime_ = regimeAt(delay, longestDelay_);
}

bool RegimeByAge::advance(double age, LinkRegime peers, double dt) {
  age_ += (age - age_) * dt / kFilterTime;
  slowAge_ += (age - slowAge_) * dt / kLongTerm;
  const LinkRegime want = regimeAt({age, age_, slowAge_}, measured_, longestDelay_);
  better_ = want < measured_ ? better_ + dt : 0.0;
  if (want > measured_ || better_ > kProof) {
    measured_ = want;
    better_ = 0.0;
    slowAge_ = age_;
  }
  const LinkRegime before = regime_;
  regime_ = std::max(measured_, peers);
  return regime_ != before;
}

}  // namespace tandem::haptics
