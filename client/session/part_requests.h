#pragma once

// The requests of this site for parts: to own them (grab), to become a co-holder (engage), to give them back
// (release), to keep them after an outage (reclaim); and what the answers mean for the hand.
//
// 1. Each request has a number of its own, and an answer counts only for the request and the part that it
//    names.
// 2. A grab of a part that another site owns becomes an engagement in it, and an engagement in a part that
//    nobody owns becomes a grab. A part that keeps changing owners is requested kMaxRepeats times more, then
//    denied to the hand.
// 3. Only the answer to what was asked since the lease last lapsed confirms anything
//    (OwnershipView::lapses()).
// 4. A release that a server with a sick disk refused is sent again until it is answered otherwise: the hand
//    has let go, so nobody could take the part else.
// 5. A lost connection voids the open requests, and those that the hand made before it was notified of the
//    loss.
//
// Network thread.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/session/part_ownership.h"
#include "client/session/participants.h"

namespace tandem::client {

class PartRequests {
 public:
  PartRequests(Participants& people, MessageSender& sender, const Watchers& watchers)
      : people_(people), sender_(sender), watchers_(watchers) {}

  /// The scene is ready, so the hand may make requests. Called once; what is referred to must outlive this.
  void sceneReady(PartOwnership& ownership, Exchange& exchange, HandEvents& events);

  // False for an answer to no open request.
  [[nodiscard]] bool handle(const sync::GrabReply& message);
  [[nodiscard]] bool handle(const sync::EngageReply& message);
  void handle(const sync::ReleaseReply& message);
  void handle(const sync::CommandReply& message);

  /// Sends the requests of the hand.
  void sendIntents();
  /// Reclaims parts in their old epoch: all that this site owned before an outage, or only those whose lease
  /// lapsed.
  void reclaim(bool all);
  /// Sends the refused releases again, every kReleaseAgain at most. `now` is local time.
  void releaseAgain(sync::Micros now);
  /// Engages again in the parts of which this site was a co-holder before an outage, as of the last
  /// reclaim(): a restarted server knows no co-holders.
  void engageAgain();
  /// The connection was lost while in the session; the hand gets an event.
  void connectionLost();

  // An instructor's commands.
  void revoke(PartId part);
  void resetParts();

 private:
  struct OpenRequest {
    std::uint32_t lapses = 0;  // of the lease before the request was sent
    sync::RequestId request = 0;
    PartId part = kNoPart;
    enum class Kind : std::uint8_t { grab, reclaim, engage, leave } kind = Kind::grab;
    int before = 0;  // earlier requests for the part that this one repeats
  };

  sync::RequestId open(PartId part, OpenRequest::Kind kind, int before = 0);
  std::optional<OpenRequest> close(sync::RequestId request, PartId part);
  bool isReclaiming(PartId part) const;
  bool mayEngage(PartId part) const;
  void askFor(PartId part, int before);
  void release(const HandIntent& intent);
  void send(const sync::Release& release);
  void reportDenial(const sync::GrabReply& reply, bool reclaim);
  void reportDenied(const sync::PartRecord& record, const std::string& why);
  std::string partName(PartId part) const;

  Participants& people_;
  MessageSender& sender_;
  const Watchers& watchers_;
  // Null until the scene stands.
  PartOwnership* ownership_ = nullptr;
  Exchange* exchange_ = nullptr;
  HandEvents* events_ = nullptr;

  sync::RequestId nextRequest_ = 1;
  std::uint32_t lost_ = 0;  // lost connections; the hand counts the events
  std::vector<OpenRequest> open_;
  static constexpr sync::Micros kReleaseAgain = 500 * sync::kMillisecond;
  std::vector<sync::Release> unanswered_, refused_;  // releases on this connection
  sync::Micros releaseAgainAt_ = 0;                  // local time
  std::vector<Epoch> givenBack_;                     // by part: the epoch in which it was last released
  HandOutput hand_;                                  // as of the last reclaim()
};

}  // namespace tandem::client
