#pragma once

// What reaches whom, when: the states of one site on their way to all others.
//
// 1. Up to kFewSites ready sites and observers, every update goes to everybody at the end of the step in
//    which it came, encoded for each.
// 2. In a crowd, updates are encoded once for all who have the same baseline
//    (sync/wire/shared_state_sender.h). At full rate they go only to the sites that are near
//    (server/interest.h): in the step in which they came where one site touches or co-holds what the other
//    one moves, else within kSiteHold.
// 3. All others, and observers, get display rate: one of the updates of each kDisplayPeriod, of each
//    kStillPeriod while nothing changes. The newest state before a pause goes to all.
// 4. In a crowd the hands of observers go to the other sites once in kObserverPeriod, to no observer.
// 5. Messages to one peer share datagrams: a datagram leaves when it is full or its oldest message is due.
//    Nothing here allocates once its buffers have grown.

#include <cstdint>
#include <span>
#include <vector>

#include "server/interest.h"
#include "server/part_service.h"
#include "server/peers.h"
#include "server/session_context.h"
#include "sync/transport/transport.h"
#include "sync/wire/shared_state_sender.h"

namespace tandem::server {

class FanOut {
 public:
  static constexpr std::size_t kFewSites = 16;
  static constexpr sync::Micros kSiteHold = 4 * sync::kMillisecond;
  static constexpr sync::Micros kObserverHold = 16 * sync::kMillisecond;
  static constexpr sync::Micros kDisplayPeriod = 25 * sync::kMillisecond;
  static constexpr sync::Micros kStillPeriod = 250 * sync::kMillisecond;
  static constexpr sync::Micros kObserverPeriod = sync::kSecond;

  /// All that is referred to outlives this.
  FanOut(const assets::Scene& scene, const sync::WireFrame& frame, SessionContext& context,
         sync::Transport& transport, Peers& peers, const PartService& parts);

  /// Sends an update of a ready site to the others, now or later. `newest`: no later one has come.
  void relay(Peer& from, sync::StateUpdate& update, bool newest);
  /// Queues a message that leaves at the end of the step.
  void send(Peer& peer, std::span<const std::byte> message) { queue(peer, message, context_.now()); }
  /// Queues a message that may wait for others in a crowd.
  void sendSoon(Peer& peer, std::span<const std::byte> message);
  /// The peer has these updates.
  void acknowledged(Peer& peer, const sync::StateAck& ack);
  /// At the end of a step: sends what is due.
  void flush();
  /// Session time at which flush() has something to do, at the latest.
  sync::Micros nextDeadline() const;
  /// Frees the baselines of a site that is not coming back.
  void forget(SiteId origin);

 private:
  static constexpr sync::Micros kInterestPeriod = 50 * sync::kMillisecond;
  static constexpr sync::Micros kPendingPeriod = 10 * sync::kMillisecond;
  static constexpr std::uint8_t kNearTicks = 10;  // a site stays near for half a second longer
  /// What one site is to another one.
  struct Pair {
    std::uint8_t near = 0;  // kInterestPeriods for which it still is
    bool touches = false;
  };
  struct Waiting {
    sync::ConnectionId connection = 0;
    sync::Micros by = 0;
  };
  /// Peers whose datagram waits, first come first out.
  struct WaitingLine {
    std::vector<Waiting> all;
    std::size_t first = 0;
    void push(Waiting waiting);
    const Waiting* front() const { return first < all.size() ? &all[first] : nullptr; }
    void pop() { ++first; }
  };

  void relayToAll(const Peer& from, sync::StateUpdate& update);
  /// Sends an update to the sites that are near, or to all.
  void deliver(Peer& from, const sync::StateUpdate& update, bool toAll);
  void deliverPending(Peer& from);
  sync::Micros displayPeriod(const Peer& from, const sync::StateUpdate& update) const;
  void queue(Peer& peer, std::span<const std::byte> message, sync::Micros by);
  void sendNow(Peer& peer);
  void sendDue(WaitingLine& line);
  /// Lists the ready peers anew, and changes between few and a crowd.
  void listReady();
  void changeTo(bool crowd);
  void compareAll();
  bool touching(const Peer& a, const Peer& b) const;
  Pair& pair(const Peer& a, const Peer& b) { return pairs_[a.states.place * sites_.size() + b.states.place]; }

  sync::WireFrame frame_;
  SessionContext& context_;
  sync::Transport& transport_;
  Peers& peers_;
  const PartService& parts_;
  Interest interest_;
  sync::SharedStateSender shared_;
  std::vector<Peer*> sites_, observers_;  // ready ones, as of listReady()
  std::vector<Pair> pairs_;               // sites_ x sites_
  std::uint64_t listed_ = 0;              // Peers::changes() at listReady()
  bool crowd_ = false;
  sync::Micros nextInterest_ = 0, nextPending_ = 0;
  std::vector<sync::ConnectionId> leaving_;
  WaitingLine waitingSites_, waitingObservers_;
  std::vector<std::byte> encoded_;
};

}  // namespace tandem::server
