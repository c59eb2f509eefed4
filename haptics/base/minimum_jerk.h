#pragma once

// The smoothest way from one place to another (Flash & Hogan 1985).

#include <algorithm>

namespace tandem::haptics {

/// The share of the way that is gone after the share `s` of the time; before and after it 0 and 1.
inline double minimumJerk(double s) {
  const double x = std::clamp(s, 0.0, 1.0);
  return x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
}

}  // namespace tandem::haptics
