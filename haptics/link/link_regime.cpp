#include "haptics/link/link_regime.h"

#include <algorithm>

namespace tandem::haptics {
namespace {

constexpr double kSoft = 0.059, kStiffAgain = 0.049;  // s
constexpr double kAgain = 0.93;  // of the farthest delay, below which the link begins again
constexpr double kFilterTime = 0.1, kSlowTime = 1.0;  // s
constexpr double kSurelySoft = 0.064;                 // s: beyond the jitter of a stiff path
constexpr double kProof = 0.5;                        // s: a flapping link stays in the worse regime

}  // namespace

void RegimeByAge::restart(double delay) {
  age_ = slowAge_ = delay;
  better_ = 0.0;
  measured_ = regime_ = delay > farthest_ ? LinkRegime::apart
                        : delay > kSoft   ? LinkRegime::soft
                                          : LinkRegime::stiff;
}

LinkRegime RegimeByAge::wanted(double age) const {
  if (age > farthest_ || age_ > farthest_) return LinkRegime::apart;
  if (measured_ == LinkRegime::apart && age_ > kAgain * farthest_) return LinkRegime::apart;
  if (measured_ == LinkRegime::stiff)
    return age_ > kSurelySoft || slowAge_ > kSoft ? LinkRegime::soft : LinkRegime::stiff;
  return age_ < kStiffAgain ? LinkRegime::stiff : LinkRegime::soft;
}

bool RegimeByAge::advance(double age, LinkRegime peers, double dt) {
  age_ += (age - age_) * dt / kFilterTime;
  slowAge_ += (age - slowAge_) * dt / kSlowTime;
  const LinkRegime want = wanted(age);
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
