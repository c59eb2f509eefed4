#pragma once

// Decodes the state datagrams of one sender, and acknowledges the baselines (state_stream.h).

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sync/wire/limits.h"
#include "sync/wire/state_stream.h"
#include "sync/wire/wire.h"

namespace tandem::sync {

class StateReceiver {
 public:
  /// `origins`: the number of sites whose updates may arrive; 1 for the stream of a single site, whichever id
  /// it claims.
  explicit StateReceiver(std::size_t origins = kMaxSites) : origins_(origins) {}

  enum class Outcome : std::uint8_t {
    decoded,
    malformed,
    noBaseline,        // encoded against a datagram that this end does not have
    checksumMismatch,  // the checksum of the decoded states does not match
  };
  /// As decodeState, for every kind of datagram; an update without a presence gets the newest one known.
  Outcome decode(std::span<const std::byte> bytes, const WireFrame& frame, StateMessage& message);
  /// The acknowledgement that is due now; nothing if there is nothing new, or the last one is less than
  /// kAckInterval old (kCrowdAckInterval where the updates are those of many sites).
  std::optional<StateAck> drainAck(Micros now);
  void reset();
  void forget(SiteId origin);

 private:
  struct Stream {
    SiteId origin = kNoSite;
    bool hasPresence = false, hasCamera = false;
    std::uint32_t presenceSequence = 0, cameraSequence = 0;
    Presence presence;
    Pose camera;
    std::vector<KeptUpdate> kept;
  };

  Outcome decodeUpdate(BitReader& reader, const WireFrame& frame, StateUpdate& update);
  Outcome readAgainst(BitReader& reader, const KeptUpdate& baseline, Micros elapsed, std::uint32_t step,
                      const WireFrame& frame);
  Outcome readWhole(BitReader& reader);
  Stream* streamOf(SiteId origin);
  void completePresence(Stream& stream, bool camera, StateUpdate& update);
  void keep(Stream& stream, const StateUpdate& update);

  std::size_t origins_;
  std::vector<Stream> streams_;
  std::vector<PartBaseline> parts_;  // of the datagram that is being read
  StateAck ack_;
  bool everAcknowledged_ = false;
  Micros acknowledgedAt_ = 0;
};

}  // namespace tandem::sync
