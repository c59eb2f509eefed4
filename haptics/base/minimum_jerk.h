#pragma once

// The minimum-jerk profile of a reaching movement (Flash & Hogan 1985).

#include <algorithm>

namespace tandem::haptics {

/// Share of the displacement covered after the share `s` of the time: 10 s^3 - 15 s^4 + 6 s^5; 0 before and
/// 1 after it.
inline double minimumJerk(double s) {
  const double x = std::clamp(s, 0.0, 1.0);
  return x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
}

}  // namespace tandem::haptics
