#pragma once

// When an output device is told something new: on change, not more often than it can take, and zero when
// nobody has spoken for a while. Pure: times come from the caller, s.

#include <optional>

namespace tandem::haptics {

template <typename Value>
class Pacer {
 public:
  Pacer(double interval, double silence) : interval_(interval), silence_(silence) {}

  /// What to send now, if anything: `wanted`, last renewed at `heard`; Value{} once that is older than the
  /// silence allowed. A first value that is Value{} is what the device has anyway and is not sent.
  std::optional<Value> next(double now, const Value& wanted, double heard) {
    const Value value = now - heard > silence_ ? Value{} : wanted;
    if (value == sent_) return std::nullopt;
    // Letting go does not wait.
    if (started_ && now - at_ < interval_ && !(value == Value{})) return std::nullopt;
    started_ = true;
    at_ = now;
    sent_ = value;
    return value;
  }

  /// The device was told this, or forgot: after connecting.
  void reset(const Value& sent = {}) { sent_ = sent, started_ = false; }

 private:
  double interval_, silence_;
  Value sent_{};
  double at_ = 0.0;
  bool started_ = false;
};

}  // namespace tandem::haptics
