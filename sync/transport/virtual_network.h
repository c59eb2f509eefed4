#pragma once

// A network inside one process, on virtual time, for simulations and tests: the same seed gives the same
// deliveries. The server sits in the middle; conditions are site to site, so each leg gets half of the delay.
//
// 1. What is due at the same instant is delivered in the order in which it was sent: no order depends on
//    addresses or threads.
// 2. Control arrives in order and once, whatever the conditions; a loss delays it, and what was sent after
//    it, by a resend.
// 3. A connection's last event is `closed`.

#include <cstdint>
#include <memory>
#include <string>

#include "sync/transport/transport.h"
#include "sync/wire/time.h"

namespace tandem::sync {

/// Probabilities and delays of the whole path from site to site.
struct NetworkConditions {
  Micros oneWay = 0;    // through the server; half on each leg
  double jitter = 0.0;  // share of the delay, uniform, plus and minus
  double loss = 0.0;  // probability for a datagram on the whole path; control is delayed by a resend instead
  double duplicate = 0.0;
  double reorder = 0.0;  // probability that a datagram is held back by one more delay
};

class VirtualNetwork {
 public:
  VirtualNetwork(std::uint64_t seed, const NetworkConditions& conditions);
  ~VirtualNetwork();

  /// Moves virtual time; messages whose time has come can be polled.
  void advanceTo(Micros now);

  /// The server's end. At most one at a time: destroying it is a crash of the server (its sites see
  /// `closed`).
  std::unique_ptr<Transport> listen();
  /// A site's end; sees `connected` after a leg, or `closed` if there is no server. Destroying it is a crash
  /// of the site: the server sees `closed` only when `deathNoticed` has passed.
  std::unique_ptr<Transport> connect(const std::string& site, Micros deathNoticed = kSecond);

  void setConditions(const NetworkConditions& conditions);
  /// Nothing to or from this site passes from now until `until`; control arrives afterwards, datagrams are
  /// lost.
  void blackout(const std::string& site, Micros until);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace tandem::sync
