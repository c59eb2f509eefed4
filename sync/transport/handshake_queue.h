#pragma once

// Which of the peers that knock at a server begins its TLS handshake next, and which makes way when there are
// too many. Pure logic on a given time: no socket, no clock. Internal to the transport.
//
// 1. Whoever has shown a knock that the server knows goes first, as often as its budget says.
// 2. Among strangers the network goes first that has begun the fewest handshakes of late. A network within
//    its budget has the base rate; beyond it only time that nobody else needs. Those who turn out to be
//    genuine do not count, so many of them may come from one address, one after another.
// 3. A handshake costs the processor a good part of a millisecond, so the rates bound what strangers can take
//    from the sites that are present.

#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_map>

#include "sync/transport/crowd.h"
#include "sync/transport/recent_use.h"
#include "sync/wire/time.h"

namespace tandem::sync {

struct HandshakeRules {
  double knownRate = 400.0;      // handshakes a second of peers that the server knows
  double baseRate = 100.0;       // of strangers, also while the server is busy
  double idleRate = 500.0;       // of strangers, further ones in time in which nothing else is to be done
  double networkBudget = 300.0;  // handshakes of one network that are fair; they fade within half a minute
  double knockBudget = 8.0;      // of one knock, before its bearer is a stranger; likewise
  bool tellApart = true;  // false: knocks and networks count for nothing, as a control in tests
};

/// Credit that grows with time up to a tenth of a second's worth.
class Rate {
 public:
  explicit Rate(double perSecond);
  bool available(Micros now);
  void spend() { credit_ -= 1.0; }
  /// When the next one is available.
  Micros next(Micros now);

 private:
  double perSecond_, most_, credit_;
  Micros at_ = 0;
};

class HandshakeQueue {
 public:
  explicit HandshakeQueue(const HandshakeRules& rules);

  /// A connection was accepted. Ids must grow.
  void enter(VisitorId visitor, Network network);
  /// Its ClientHello is there; `knock`: the first half of a genuine knock.
  void ready(VisitorId visitor, std::optional<std::uint64_t> knock, Micros now);
  /// It is gone. Nothing happens if it is not here.
  void leave(VisitorId visitor);

  std::size_t size() const { return strangers_.size() + known_.size(); }
  /// Who makes way for others. Must not be called when empty.
  VisitorId crowded() const { return strangers_.size() > 0 ? strangers_.first() : known_.first(); }

  struct Turn {
    VisitorId visitor = 0;
    Network network = 0;
    bool known = false;
  };
  /// Whose handshake begins now; it has left the queue. `idle`: nothing else is to be done.
  std::optional<Turn> next(Micros now, bool idle);
  /// A stranger whose turn was given at that time has proven genuine: its network has used nothing by it.
  void takeBack(Network network, Micros at);
  /// When next() may give a turn, if the server is idle then; far away if nobody waits.
  Micros nextAt(Micros now);

 private:
  using Rank = std::tuple<double, VisitorId, Network>;  // use, the oldest that is ready
  struct Visitor {
    Network network = 0;
    bool ready = false;
  };
  /// The strangers of a network that are ready, and their place in the order.
  struct Ready {
    std::set<VisitorId> visitors;
    Rank rank;
  };
  /// Puts a network that has visitors into the order, by what it has used.
  void rank(Network network, Ready& ready);
  Turn take(VisitorId visitor, bool known);

  HandshakeRules rules_;
  Rate knownRate_, baseRate_, idleRate_;
  RecentUse networkUse_, knockUse_;
  std::unordered_map<VisitorId, Visitor> visitors_;
  Crowd strangers_{1}, known_;
  std::set<VisitorId> readyKnown_;
  std::unordered_map<Network, Ready> readyOf_;
  std::set<Rank> order_;  // networks of strangers that are ready
};

}  // namespace tandem::sync
