#pragma once

// Publishes the states of this site's parts, hand and camera. state_publisher.h decides when.
//
// 1. Only what the ownership view allows is published: parts in the epoch in which this site owns them, while
//    its lease runs (S3). The hand keeps simulating them either way.
//
// Network thread.

#include <cstdint>
#include <vector>

#include "client/session/part_ownership.h"
#include "client/session/participants.h"
#include "client/session/state_publisher.h"
#include "sync/wire/state_sender.h"

namespace tandem::client {

class StatePublishing {
 public:
  /// What is referred to must outlive this.
  StatePublishing(PartOwnership& ownership, const Participants& people, Exchange& exchange,
                  MessageSender& sender, SessionClock& clock, const Watchers& watchers,
                  const PublishRates& rates);

  /// A new connection: the server has no baseline.
  void reset();
  /// The server acknowledges updates, which later ones may be encoded against.
  void handle(const sync::StateAck& message) { encoder_.acknowledged(message); }
  /// Sends an update if one is due.
  void publish(const Pose& worldFromCamera);

  std::uint64_t updatesOfConnection() const { return updatesOfConnection_; }
  std::uint64_t updates() const { return updates_; }  // of all connections

 private:
  bool othersTouch(PartId part) const;
  void offerParts(const HandOutput& hand);

  PartOwnership& ownership_;
  const Participants& people_;
  Exchange& exchange_;
  MessageSender& sender_;
  SessionClock& clock_;
  const Watchers& watchers_;

  StatePublisher publisher_;
  sync::StateSender encoder_;
  std::vector<OfferedPart> offered_;
  std::uint32_t sequence_ = 0;
  std::uint64_t updatesOfConnection_ = 0, updates_ = 0;
  sync::StateMessage message_{sync::StateUpdate{}};
  std::vector<std::byte> bytes_;
};

}  // namespace tandem::client
