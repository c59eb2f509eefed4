#pragma once

// What share of the datagrams on a way was lost, since both of its ends listen.

#include <algorithm>
#include <cstdint>
#include <optional>

namespace tandem::client {

/// Fed with two counts that only grow: what was sent and, of that, what has arrived. What was sent before the
/// first arrival is no loss: the other end did not listen yet.
class LossMeter {
 public:
  void observe(std::uint64_t sent, std::uint64_t arrived) {
    if (!began_ && arrived > 0) began_ = Counts{sent, arrived};
    if (!began_ || sent <= began_->sent) return;
    const auto expected = static_cast<double>(sent - began_->sent);
    const double came = arrived > began_->arrived ? static_cast<double>(arrived - began_->arrived) : 0.0;
    loss_ = std::clamp(1.0 - came / expected, 0.0, 1.0);
  }

  /// 0..1
  double loss() const { return loss_; }

 private:
  struct Counts {
    std::uint64_t sent = 0, arrived = 0;
  };
  std::optional<Counts> began_;
  double loss_ = 0.0;
};

}  // namespace tandem::client
