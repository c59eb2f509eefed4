#pragma once

#include <string>

namespace tandem::client::report {

/// A target of the project and the measured figure.
struct Bound {
  std::string name, unit;
  double measured = 0.0, target = 0.0;
  bool atLeast = false;
  bool met() const { return atLeast ? measured >= target * (1.0 - 1e-9) : measured <= target; }
};

}  // namespace tandem::client::report
