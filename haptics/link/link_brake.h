#pragma once

// Holds a replica where the force of its link breaks off for want of energy, so that a hand on it does not
// feel the break: dry friction of what is missing, which decays as a force that ends does. It takes energy
// only, and so needs none.

#include <algorithm>

#include "haptics/base/six_axes.h"

namespace tandem::haptics {

class LinkBrake {
 public:
  /// Begins a tick of dt s; the friction decays at `rate` N/s.
  void advance(double rate, double dt) { force_ = std::max(0.0, force_ - rate * dt); }
  /// The link lacks this force, N, on a replica that moves at v: what would have slowed it is replaced.
  void replace(const SixAxes& missing, const SixAxes& v) {
    force_ = std::max(force_, -dot(missing, v) / slowest(v) - kIgnored);
  }
  /// This much of the force, N, ends sooner than it should.
  void add(double force) { force_ += force; }
  void release() { force_ = 0.0; }
  /// N·s/m, on a replica that moves at v.
  double damping(const SixAxes& v) const { return force_ / slowest(v); }

 private:
  static constexpr double kIgnored = 0.1;   // N: honest links lack as much for some ticks
  static constexpr double kSlowest = 2e-3;  // m/s, below which it is viscous

  static double slowest(const SixAxes& v) { return std::max(length(v), kSlowest); }

  double force_ = 0.0;  // N
};

}  // namespace tandem::haptics
