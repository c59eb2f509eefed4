#pragma once

// What this site asks the server for its parts: to own them, to share them, to give them back, to get them
// again after an outage; and what the answers mean to the hand.
//
// 1. Each request has a number of its own, and an answer counts only for the request and the part that it
//    names.
// 2. A grab of a part that another site owns becomes an engagement in it, and an engagement in a part that
//    nobody owns becomes a grab. A part that keeps changing owners is asked for kMaxRepeats times more, then
//    the hand is denied it.
// 3. Only the answer to what was asked since the lease last lapsed confirms anything
//    (OwnershipView::lapses()).
// 4. A lost connection voids the open requests, and those that the hand made before it heard of the loss.
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

  /// The scene stands: the hand may ask. Once; what is referred to must outlive this.
  void sceneReady(PartOwnership& ownership, Exchange& exchange, HandEvents& events);

  // False for an answer to nothing that was asked.
  [[nodiscard]] bool handle(const sync::GrabReply& message);
  [[nodiscard]] bool handle(const sync::EngageReply& message);
  void handle(const sync::ReleaseReply& message);
  void handle(const sync::CommandReply& message);

  /// Sends what the hand asks for.
  void sendIntents();
  /// Asks again for parts in their old epoch: for all that were this site's before an outage, or only for
  /// those of which the lease lapsed.
  void reclaim(bool all);
  /// Asks again for the parts that this site shared before an outage, as of the last reclaim(): a restarted
  /// server knows of no sharing.
  void shareAgain();
  /// The connection was lost while in the session; the hand is told.
  void connectionLost();

  // An instructor's commands.
  void revoke(PartId part);
  void resetParts();

 private:
  struct OpenRequest {
    std::uint32_t lapses = 0;  // of the lease, before it was sent
    sync::RequestId request = 0;
    PartId part = kNoPart;
    enum class Kind : std::uint8_t { grab, reclaim, engage, leave } kind = Kind::grab;
    int before = 0;  // requests that this one repeats, as the part came and went
  };

  sync::RequestId open(PartId part, OpenRequest::Kind kind, int before = 0);
  std::optional<OpenRequest> close(sync::RequestId request, PartId part);
  bool isReclaiming(PartId part) const;
  bool mayShare(PartId part) const;
  void askFor(PartId part, int before);
  void release(const HandIntent& intent);
  void tellDenial(const sync::GrabReply& reply, bool reclaim);
  void tellDenied(const sync::PartRecord& record, const std::string& why);
  std::string partName(PartId part) const;

  Participants& people_;
  MessageSender& sender_;
  const Watchers& watchers_;
  // Null until the scene stands.
  PartOwnership* ownership_ = nullptr;
  Exchange* exchange_ = nullptr;
  HandEvents* events_ = nullptr;

  sync::RequestId nextRequest_ = 1;
  std::uint32_t lost_ = 0;  // connections, as the hand is told
  std::vector<OpenRequest> open_;
  std::vector<Epoch> givenBack_;  // by part, in which it was released last
  HandOutput hand_;               // as of the last reclaim()
};

}  // namespace tandem::client
