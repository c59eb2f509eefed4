#pragma once

// A site's pings. The answers set the session clock, measure the round trip, and tell how many of the updates
// arrived at the server. Their renewal of the leases is OwnershipView::renewed(). A server that answers none
// of them for kPatience is taken for gone, although its connection stands.
//
// Network thread.

#include <cstdint>

#include "client/base/loss_meter.h"
#include "client/session/session_clock.h"
#include "sync/wire/clock_messages.h"

namespace tandem::client {

class Pings {
 public:
  /// The clock must outlive this.
  Pings(sync::Micros interval, SessionClock& clock) : interval_(interval), clock_(clock) {}

  /// A new connection: nothing is measured yet, and a ping is due at once.
  void reset();
  bool due() const { return clock_.now() >= next_; }
  /// The ping to be sent in this step. `updatesSent` counts the updates of this connection so far.
  sync::Ping next(std::uint64_t updatesSent);
  /// False for an answer whose ping lies in the future or over kMaxPongAge back, which changes nothing.
  [[nodiscard]] bool observe(const sync::Pong& pong);

  /// Whether every ping of the last kPatience went unanswered. Some must have been sent meanwhile: a site
  /// that itself stood still does not blame the server.
  bool serverIsSilent() const {
    return unanswered_ >= kEnoughUnanswered && clock_.now() - unansweredSince_ >= kPatience;
  }

  double roundTrip_ms() const { return roundTrip_ms_; }  // 0 before the first answer
  double lossUp() const { return lossUp_.loss(); }       // of the updates of this connection, 0..1

  static constexpr sync::Micros kMaxPongAge = 10 * sync::kSecond;
  /// Beyond StateChannel's kPathSilence, after which pings change from a lost UDP path to TLS, and a long
  /// round trip.
  static constexpr sync::Micros kPatience = 1700 * sync::kMillisecond;
  static constexpr int kEnoughUnanswered = 5;

 private:
  sync::Micros interval_;
  SessionClock& clock_;
  std::uint32_t sequence_ = 0;
  sync::Micros next_ = 0;             // local time
  int unanswered_ = 0;                // pings since the newest answer
  sync::Micros unansweredSince_ = 0;  // local time of the first of them
  std::uint64_t updatesAtPing_ = 0;
  LossMeter lossUp_;
  double roundTrip_ms_ = 0.0;
};

}  // namespace tandem::client
