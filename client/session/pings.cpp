#include "client/session/pings.h"

#include "assets/base/assert.h"

namespace tandem::client {

using namespace sync;

void Pings::reset() {
  next_ = clock_.now();
  unanswered_ = 0;
  updatesAtPing_ = 0;
  lossUp_ = {};
  roundTrip_ms_ = 0.0;
}

Ping Pings::next(std::uint64_t updatesSent) {
  ASSERT(due() && updatesSent >= updatesAtPing_);
  next_ = clock_.now() + interval_;
  if (unanswered_++ == 0) unansweredSince_ = clock_.now();
  updatesAtPing_ = updatesSent;
  return {++sequence_, clock_.now()};
}

bool Pings::observe(const Pong& pong) {
  const Micros now = clock_.now();
  if (pong.siteTime > now || now - pong.siteTime > kMaxPongAge) return false;
  unanswered_ = 0;
  clock_.observe(pong.siteTime, pong.serverTime);
  roundTrip_ms_ = toSeconds(clock_.lastRoundTrip()) * 1e3;
  ASSERT(roundTrip_ms_ >= 0.0);
  // Only the newest ping's count stands beside the newest count of sent updates.
  if (pong.sequence == sequence_) lossUp_.observe(updatesAtPing_, pong.received);
  return true;
}

}  // namespace tandem::client
