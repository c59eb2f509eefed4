#pragma once

// Receives the state datagrams of the server: decodes them, checks them against ownership, passes them to the
// hand, acknowledges them, and derives play-out delay and loss from their arrivals.
//
// Network thread.

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "client/base/loss_meter.h"
#include "client/session/doubts.h"
#include "client/session/part_ownership.h"
#include "client/session/participants.h"
#include "sync/replica/play_out.h"
#include "sync/wire/state_receiver.h"

namespace tandem::client {

class StateReceiving {
 public:
  struct Counts {
    std::uint64_t updates = 0, droppedStates = 0;
    std::uint64_t droppedBaselines = 0;  // updates whose baseline is missing or whose checksum does not match
  };

  /// What is referred to must outlive this.
  StateReceiving(PartOwnership& ownership, Participants& people, Doubts& doubts, Exchange& exchange,
                 HandEvents& events, MessageSender& sender, SessionClock& clock, const Watchers& watchers);

  /// A new connection: the server counts and encodes anew.
  void reset();
  /// A site that is not coming back.
  void forget(SiteId site) { receiver_.forget(site); }

  /// Reads a datagram into message(), or counts it as dropped. The caller counts malformed ones.
  [[nodiscard]] sync::StateReceiver::Outcome decode(std::span<const std::byte> bytes);
  const sync::StateMessage& message() const { return message_; }
  /// `update` is that of message().
  void handle(const sync::StateUpdate& update);
  /// Acknowledges the updates that have arrived, so that the server may encode later ones against them.
  void acknowledge();
  /// Tells the server of the sites whose link packets the hand's loop does not believe.
  void drainDoubts();
  /// Gives the hand the session's time and the play-out delay.
  void publishTimeBase();

  const Counts& counts() const { return counts_; }
  double loss() const { return loss_.loss(); }  // of the datagrams on this connection, 0..1
  sync::Micros playOutDelay() const { return playOut_; }

 private:
  void countLoss(std::uint32_t sequence);
  bool isNewest(const sync::StateUpdate& update);
  void accept(const sync::StateUpdate& update, const sync::PartState& state);

  PartOwnership& ownership_;
  Participants& people_;
  Doubts& doubts_;
  Exchange& exchange_;
  HandEvents& events_;
  MessageSender& sender_;
  SessionClock& clock_;
  const Watchers& watchers_;

  sync::StateReceiver receiver_;
  sync::StateMessage message_;
  std::vector<std::pair<SiteId, std::uint32_t>> newestOf_;  // sequence of the newest update of each site
  // Of all updates on this connection, of whichever site: the server numbers them in one sequence.
  std::uint64_t expected_ = 0, arrived_ = 0;
  std::uint32_t newest_ = 0;  // sequence
  LossMeter loss_;
  sync::PlayOutDelay delay_;
  sync::Micros playOut_ = 0;
  Counts counts_;
};

}  // namespace tandem::client
