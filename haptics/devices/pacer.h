#pragma once

// Pacing of an output device: it sends on change, no more often than the device can take, and sends zero
// after a silence of the caller. Pure: the caller provides the times, s.

#include <optional>

#include "assets/base/assert.h"

namespace tandem::haptics {

template <typename Value>
class Pacer {
 public:
  Pacer(double interval, double silence) : interval_(interval), silence_(silence) {
    ASSERT(interval >= 0.0 && silence >= 0.0);
  }

  /// The value to send now, if any: `wanted`, last renewed at `renewedAt`, or Value{} once that is older than
  /// the allowed silence. An initial Value{} is not sent, because the device has that value anyway.
  std::optional<Value> next(double now, const Value& wanted, double renewedAt) {
    const Value value = now - renewedAt > silence_ ? Value{} : wanted;
    if (value == sent_) return std::nullopt;
    // A release is sent at once.
    if (started_ && now - at_ < interval_ && !(value == Value{})) return std::nullopt;
    started_ = true;
    at_ = now;
    sent_ = value;
    return value;
  }

  /// Notes that the device was sent this value, or after connecting, that it has lost its state.
  void reset(const Value& sent = {}) { sent_ = sent, started_ = false; }

 private:
  double interval_, silence_;
  Value sent_{};
  double at_ = 0.0;
  bool started_ = false;
};

}  // namespace tandem::haptics
