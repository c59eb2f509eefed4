#pragma once

// The energy that an end of a link may spend beyond what has arrived: a bounded store that only what the end itself has
// lost, or has not used, fills. It is the only source there is.

#include <algorithm>

namespace tandem::haptics {

class LinkReserve {
 public:
  static constexpr double kMost = 0.03;  // J: 10 mJ did not carry a drag of 5 cm through an outage
  static constexpr double kKept = 0.8;   // of what is lost: the rest is margin

  double energy() const { return energy_; }

  /// The share of an arriving wave to take in. Two hands that pull at each other and hold still lose nothing that could
  /// fill the reserve, and every late packet would then be felt: until there is some, the wave comes in a little short.
  double taken() const { return energy_ < kFloat ? kTaken : 1.0; }

  /// Fills with a share of what damping has taken, J.
  void fill(double lost) { energy_ = std::max(energy_, std::min(energy_ + kKept * lost, kMost)); }

  /// Settles a tick that may leave a surplus for later ones. Returns what of `arrived` (J) is used up: `cost`, and what
  /// the reserve takes back of it, first what it has lent.
  double settle(double arrived, double cost) {
    const double left = arrived - cost;
    if (left < 0.0) return energy_ += left, arrived;
    const double back = std::min(std::max((energy_ < kFloat ? 1.0 : kSkimmed) * left, std::min(lent_, left)),
                                 std::max(0.0, kMost - energy_));
    energy_ += back;
    lent_ = std::max(0.0, lent_ - back);
    return cost + back;
  }

  /// Settles a tick that uses all of `arrived` (J); `lends`: what is beyond that is to come back.
  void settleAll(double arrived, double cost, bool lends) {
    const double left = arrived - cost;
    lent_ = lends ? lent_ + std::max(0.0, -left) : 0.0;
    energy_ = left < 0.0 ? energy_ + left : std::max(energy_, std::min(energy_ + left, kMost));
  }

 private:
  static constexpr double kSkimmed = 0.02;  // of a surplus, a tick
  static constexpr double kFloat = 0.3e-3;  // J: the dearest wave for some ten ticks
  static constexpr double kTaken = 0.997;

  double energy_ = 0.0;  // J
  double lent_ = 0.0;    // J, while the link was dry for a moment
};

}  // namespace tandem::haptics
