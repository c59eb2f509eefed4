#pragma once

// Which readings of a device a tick may act on.

#include <cstdint>
#include <limits>

#include "haptics/base/device.h"
#include "haptics/base/tick_types.h"

namespace tandem::haptics {

/// Judges one reading a tick.
///
/// 1. Not valid, not finite or absurd: refused.
/// 2. Stale, its time stamp not finite or not beyond the newest one for longer than
///    TickParameters::staleAfter: refused until the stamp goes on. A clock that was set back is followed from
///    where it has come to in that time. A stamp of 0 means that the device has none.
/// 3. A jump, farther from the last good reading than a hand moves in the time since at
///    TickParameters::maxDeviceSpeed: refused. A single glitch is over with the next reading. A place that
///    stays for kJumpTicks ticks is where the hand now is: accepted, with the proxy put onto it.
class SampleGuard {
 public:
  static constexpr int kJumpTicks = 5;

  enum class Verdict : std::uint8_t { good, refused, elsewhere /* good, but not reached by moving there */ };

  /// `silence`: s since the last good reading. Sets the flags that apply.
  Verdict judge(const DeviceSample& sample, const TickParameters& parameters, double silence,
                std::uint32_t& flags);

 private:
  bool stale(const DeviceSample& sample, const TickParameters& parameters);
  Verdict judgePlace(const glm::dvec3& place, double speed, double dt, double silence, std::uint32_t& flags);

  bool started_ = false;
  glm::dvec3 good_{0.0, 0.0, 0.0}, candidate_{0.0, 0.0, 0.0};
  int candidateTicks_ = 0;
  static constexpr double kNever = -std::numeric_limits<double>::infinity();
  double newest_ = kNever, age_ = 0.0;  // s: the newest stamp, and for how long it has been the newest
  double latest_ = kNever,
         waited_ = 0.0;  // s: the latest stamp of the last `waited_`, that only lasts so long
};

}  // namespace tandem::haptics
