#include "sync/transport/handshake_queue.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

constexpr Micros kMemory = 30 * kSecond;  // of what a network or a knock has used
constexpr double kBurst_s = 0.1;

}  // namespace

Rate::Rate(double perSecond)
    : perSecond_(perSecond), most_(std::max(1.0, perSecond * kBurst_s)), credit_(most_) {}

bool Rate::available(Micros now) {
  const auto passed_s = 1e-6 * static_cast<double>(std::max<Micros>(0, now - at_));
  credit_ = std::min(most_, credit_ + perSecond_ * passed_s);
  at_ = now;
  return credit_ >= 1.0;
}

Micros Rate::next(Micros now) {
  if (available(now)) return now;
  return now + 1 + static_cast<Micros>(std::ceil((1.0 - credit_) / perSecond_ * 1e6));
}

HandshakeQueue::HandshakeQueue(const HandshakeRules& rules)
    : rules_(rules),
      knownRate_(rules.knownRate),
      baseRate_(rules.baseRate),
      idleRate_(rules.idleRate),
      networkUse_(kMemory),
      knockUse_(kMemory) {}

void HandshakeQueue::enter(VisitorId visitor, Network network) {
  if (!rules_.tellApart) network = 0;
  visitors_[visitor].network = network;
  strangers_.add(visitor, network);
}

void HandshakeQueue::rank(Network network, Ready& ready) {
  order_.erase(ready.rank);
  ready.rank = {networkUse_.order(network), *ready.visitors.begin(), network};
  order_.insert(ready.rank);
}

void HandshakeQueue::ready(VisitorId visitor, std::optional<std::uint64_t> knock, Micros now) {
  const auto found = visitors_.find(visitor);
  if (found == visitors_.end() || found->second.ready) return;
  found->second.ready = true;
  const Network network = found->second.network;
  if (knock && rules_.tellApart && knockUse_.count(*knock, now) < rules_.knockBudget) {
    knockUse_.add(*knock, now);
    strangers_.remove(visitor);
    known_.add(visitor, network);
    readyKnown_.insert(visitor);
    return;
  }
  Ready& ready = readyOf_[network];
  ready.visitors.insert(visitor);
  rank(network, ready);
}

void HandshakeQueue::leave(VisitorId visitor) {
  const auto found = visitors_.find(visitor);
  if (found == visitors_.end()) return;
  const Network network = found->second.network;
  if (const auto at = readyOf_.find(network); at != readyOf_.end()) {
    Ready& ready = at->second;
    ready.visitors.erase(visitor);
    if (ready.visitors.empty()) {
      order_.erase(ready.rank);
      readyOf_.erase(at);
    } else {
      rank(network, ready);
    }
  }
  readyKnown_.erase(visitor);
  strangers_.remove(visitor);
  known_.remove(visitor);
  visitors_.erase(found);
}

HandshakeQueue::Turn HandshakeQueue::take(VisitorId visitor, bool known) {
  const Turn turn{visitor, visitors_.at(visitor).network, known};
  leave(visitor);
  return turn;
}

std::optional<HandshakeQueue::Turn> HandshakeQueue::next(Micros now, bool idle) {
  if (!readyKnown_.empty() && knownRate_.available(now)) {
    knownRate_.spend();
    return take(*readyKnown_.begin(), true);
  }
  if (order_.empty()) return std::nullopt;
  const VisitorId visitor = std::get<1>(*order_.begin());
  const Network network = std::get<2>(*order_.begin());
  const bool fair = networkUse_.count(network, now) < rules_.networkBudget;
  if (idle && idleRate_.available(now))
    idleRate_.spend();
  else if (fair && baseRate_.available(now))
    baseRate_.spend();
  else
    return std::nullopt;
  networkUse_.add(network, now);
  return take(visitor, false);
}

void HandshakeQueue::takeBack(Network network, Micros at) {
  if (!rules_.tellApart) return;
  networkUse_.takeBack(network, at);
  if (const auto ready = readyOf_.find(network); ready != readyOf_.end()) rank(network, ready->second);
}

Micros HandshakeQueue::nextAt(Micros now) {
  Micros at = std::numeric_limits<Micros>::max();
  if (!readyKnown_.empty()) at = std::min(at, knownRate_.next(now));
  if (!order_.empty()) at = std::min({at, idleRate_.next(now)});
  return at;
}

}  // namespace tandem::sync
