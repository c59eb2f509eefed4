#pragma once

// Energy reserve of a link end: what it may spend beyond what has arrived (passivity). It is bounded, and
// only energy that the end itself has dissipated or not used fills it.

#include <algorithm>

namespace tandem::haptics {

class LinkReserve {
 public:
  static constexpr double kMax = 0.03;  // J: 10 mJ did not carry a drag of 5 cm through an outage
  static constexpr double kKept = 0.8;  // of the dissipated energy; the rest is margin

  double energy() const { return energy_; }

  /// Accepted share of an incoming wave. Two hands that pull at each other and hold still dissipate nothing
  /// that could fill the reserve, and every late packet would then be felt. Until the reserve holds some
  /// energy, slightly less than the whole wave is accepted.
  double acceptedShare() const { return energy_ < kFloat ? kAcceptedShare : 1.0; }

  /// Fills the reserve with a share of the energy that damping has dissipated, J.
  void fill(double lost) { energy_ = std::max(energy_, std::min(energy_ + kKept * lost, kMax)); }

  /// Accounts for a tick that may leave a surplus for later ones. Returns the share of `arrived` (J) that is
  /// used up: `cost`, and what the reserve takes back, first what it has borrowed.
  double account(double arrived, double cost) {
    const double left = arrived - cost;
    if (left < 0.0) return energy_ += left, arrived;
    const double back =
        std::min(std::max((energy_ < kFloat ? 1.0 : kSkimmed) * left, std::min(borrowed_, left)),
                 std::max(0.0, kMax - energy_));
    energy_ += back;
    borrowed_ = std::max(0.0, borrowed_ - back);
    return cost + back;
  }

  /// Accounts for a tick that uses all of `arrived` (J). With `borrows`, spending beyond that is to be paid
  /// back later.
  void accountAll(double arrived, double cost, bool borrows) {
    const double left = arrived - cost;
    borrowed_ = borrows ? borrowed_ + std::max(0.0, -left) : 0.0;
    energy_ = left < 0.0 ? energy_ + left : std::max(energy_, std::min(energy_ + left, kMax));
  }

 private:
  static constexpr double kSkimmed = 0.02;  // of a surplus, per tick
  static constexpr double kFloat = 0.3e-3;  // J: covers the most expensive wave for some ten ticks
  static constexpr double kAcceptedShare = 0.997;

  double energy_ = 0.0;    // J
  double borrowed_ = 0.0;  // J, while the link was starved for a short time
};

}  // namespace tandem::haptics
