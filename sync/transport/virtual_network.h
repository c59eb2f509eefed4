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
#include <optional>
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

  /// The same in one direction.
  enum class Way : std::uint8_t { toServer, toSite };
  void cut(const std::string& site, Way way, Micros until);

  /// What is special about the leg between one site and the server, beside the conditions.
  struct Path {
    Micros delay = 0;         // more, each way
    double loss = 0.0;        // more; control is delayed by a resend instead
    double uplinkRate = 0.0;  // bytes/s from the site; 0: any. What does not pass queues, up to a second
  };
  void setPath(const std::string& site, const Path& path);
  Path path(const std::string& site) const;
  /// Ends all cuts, takes back every setPath(), and sends again at once what losses had held back.
  void healAll();

  /// When the server last received what an end of this site had sent that is closed by now, or destroyed; 0:
  /// never.
  Micros lastFromTheDead(const std::string& site) const;
  /// How often it did, of all sites.
  std::uint64_t heardFromTheDead() const;
  /// When the next message arrives; nothing if none is under way.
  std::optional<Micros> nextArrival() const;
  /// Whether an end of this network has events to be polled. It must be one of a VirtualNetwork.
  static bool hasEvents(const Transport& transport);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace tandem::sync
