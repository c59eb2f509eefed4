#pragma once

// Encodes the StateUpdates to one receiver as differences to acknowledged baselines (state_stream.h).

#include <cstdint>
#include <optional>
#include <vector>

#include "sync/wire/state_stream.h"
#include "sync/wire/wire.h"

namespace tandem::sync {

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
  /// What goes into an update beside the parts.
  struct With {
    bool presence = false, camera = false, second = false;
  };
  struct Stream {
    SiteId origin = kNoSite;
    int presences = 0;  // sent since the camera moved
    Pose camera;        // as sent last
    bool everKept = false;
    Micros keptAt = 0;
    std::size_t next = 0;  // in `kept`, to be replaced
    std::vector<KeptUpdate> kept;

    With choose(const StateUpdate& update);
  };
  /// How one part of the baseline is encoded.
  struct Plan {
    const PartBaseline* baseline = nullptr;
    int code = -1;  // in codes_; -1: it is not in this datagram
    bool same = false;
    DeltaOrders orders{};
  };

  Stream& streamOf(SiteId origin);
  const KeptUpdate* baselineFor(const Stream& stream, const StateUpdate& update) const;
  std::optional<std::uint32_t> stepFrom(const KeptUpdate& baseline) const;
  void plan(const KeptUpdate* baseline, Micros elapsed, std::optional<std::uint32_t> step,
            const WireFrame& frame, int room);
  void write(const StateUpdate& update, const KeptUpdate* baseline, std::uint32_t step, bool keep, With with,
             const WireFrame& frame, std::vector<std::byte>& bytes, EncodeLosses& losses);
  void keep(Stream& stream, const StateUpdate& update, Micros elapsed);

  std::vector<Stream> streams_;
  std::vector<PartCode> codes_;
  std::vector<Plan> plans_;         // of the baseline's parts
  std::vector<std::size_t> whole_;  // in codes_
  std::vector<PartBaseline> spare_;
};

}  // namespace tandem::sync
