#pragma once

// StateUpdates from one end of a connection to the other in few bytes: parts are encoded as differences to a
// datagram that the receiver has acknowledged. Site to server and server to each site are streams of their
// own, each with its own losses; the server decodes and encodes in between.
//
// 1. Every datagram is decodable alone by whoever has its baseline, and says which one that is. Whoever lacks
//    it drops the datagram and counts it: nothing is ever applied to another baseline.
// 2. Baselines: at most every kKeepInterval the sender marks a datagram to be kept. The receiver keeps it and
//    acknowledges it; the sender encodes against the newest acknowledged one that it still has. Both keep the
//    newest kKept that were marked, so what the sender chooses, the receiver has.
// 3. Without an acknowledged baseline (at the start, after an outage of a second) parts are sent whole: a
//    receiver is never further from a usable state than the next datagram.
// 4. Each datagram against a baseline carries a checksum of the decoded states.
// 5. Both ends keep integer codes, not floating-point numbers, and predict from them: no error accumulates.
//
// No allocation once the buffers have grown. One thread.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sync/wire/part_delta.h"
#include "sync/wire/wire.h"

namespace tandem::sync {

inline constexpr Micros kKeepInterval = 40 * kMillisecond;  // by the update's own times
inline constexpr std::size_t kKept = 24;                    // a stream: about a second
inline constexpr Micros kAckInterval = 20 * kMillisecond;   // at least, between two acknowledgements

/// The parts of a datagram that both ends keep as a baseline.
struct KeptUpdate {
  std::uint32_t sequence = 0;
  Micros time = 0;
  bool acknowledged = false;  // at the sender
  std::vector<PartBaseline> parts;
};

class StateSender {
 public:
  /// Replaces `bytes`. Parts from the back of update.parts are left out if they do not fit; presence goes
  /// along where it is new (StateUpdate::newPresence), or new to this receiver; of it the camera where that
  /// moved, and at times.
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
    bool presence = false, camera = false;
  };
  struct Stream {
    SiteId origin = kNoSite;
    int presences = 0;  // sent since the camera moved
    Pose camera;        // as sent last
    bool everKept = false;
    Micros keptAt = 0;
    std::size_t next = 0;  // in `kept`, to be replaced
    std::vector<KeptUpdate> kept;

    With goesAlong(const StateUpdate& update);
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

class StateReceiver {
 public:
  /// `origins`: of how many sites updates may come; one for what a site itself sends, whatever it says it is.
  explicit StateReceiver(std::size_t origins = kMaxSites) : origins_(origins) {}

  enum class Outcome : std::uint8_t {
    taken,
    malformed,
    noBaseline,  // against a datagram that this end does not have
    spoilt,      // the checksum of the decoded states does not match
  };
  /// As decodeState, for every kind of datagram; an update without a presence gets the newest one known.
  Outcome decode(std::span<const std::byte> bytes, const WireFrame& frame, StateMessage& message);
  /// The acknowledgement that is due now; nothing if there is nothing new, or the last one is less than
  /// kAckInterval old.
  std::optional<StateAck> takeAck(Micros now);
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
  void takePresence(Stream& stream, bool camera, StateUpdate& update);
  void keep(Stream& stream, const StateUpdate& update);

  std::size_t origins_;
  std::vector<Stream> streams_;
  std::vector<PartBaseline> parts_;  // of the datagram that is being read
  StateAck ack_;
  bool everAcknowledged_ = false;
  Micros acknowledgedAt_ = 0;
};

}  // namespace tandem::sync
