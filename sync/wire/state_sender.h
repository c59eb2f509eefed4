#pragma once

// Encodes the StateUpdates to one receiver as differences to acknowledged baselines (state_stream.h).

#include <cstdint>
#include <vector>

#include "sync/wire/state_stream.h"
#include "sync/wire/state_writer.h"
#include "sync/wire/wire.h"

namespace tandem::sync {

/// Presences with a camera at rest, since datagrams get lost.
inline constexpr int kCameraAtFirst = 4, kCameraEvery = 8;

class StateSender {
 public:
  /// Replaces `bytes`. Parts from the back of update.parts are left out if they do not fit; presence is
  /// included where it is new (StateUpdate::newPresence) or new to this receiver, its camera after it moved
  /// and at intervals.
  void encode(const StateUpdate& update, const WireFrame& frame, std::vector<std::byte>& bytes,
              EncodeLosses* losses = nullptr);
  void acknowledged(const StateAck& ack);
  /// The connection is a new one: the receiver has no baseline.
  void reset() { streams_.clear(); }
  /// Frees the stream of an origin that is not coming back.
  void forget(SiteId origin);

 private:
  struct Stream {
    SiteId origin = kNoSite;
    int presences = 0;  // sent since the camera moved
    Pose camera;        // as sent last
    bool everKept = false;
    Micros keptAt = 0;
    std::size_t next = 0;  // in `kept`, to be replaced
    std::vector<KeptUpdate> kept;

    StateWriter::With choose(const StateUpdate& update);
  };

  Stream& streamOf(SiteId origin);
  const KeptUpdate* baselineFor(const Stream& stream, const StateUpdate& update) const;
  void keep(Stream& stream, const StateUpdate& update, Micros elapsed);

  std::vector<Stream> streams_;
  StateWriter writer_;
  std::vector<PartBaseline> spare_;
};

}  // namespace tandem::sync
