#pragma once

// The share of datagrams in one direction that was lost since both ends listen.

#include <algorithm>
#include <cstdint>
#include <optional>

namespace tandem::client {

/// Observes two counts that only grow: datagrams sent, and those of them that have arrived. Datagrams sent
/// before the first arrival count as no loss, because the other end did not listen yet.
class LossMeter {
 public:
  void observe(std::uint64_t sent, std::uint64_t arrived) {
    if (!began_ && arrived > 0) began_ = Counts{sent, arrived};
    if (!began_ || sent <= began_->sent) return;
    const auto expected = static_cast<double>(sent - began_->sent);
    const double came = arrived > began_->arrived ? static_cast<double>(arrived - began_->arrived) : 0.0;
    loss_ = std::clamp(1.0 - came / expected, 0.0, 1.0);
  }

  /// The share of datagrams lost, 0..1.
  double loss() const { return loss_; }

 private:
  struct Counts {
    std::uint64_t sent = 0, arrived = 0;
  };
  std::optional<Counts> began_;
  double loss_ = 0.0;
};

}  // namespace tandem::client
