#pragma once

// The UDP path of one connection: seals and opens its datagrams, and decides from probes whether state may
// use it. It has no socket and no clock: its owner moves the bytes and passes the time.
//
// 1. The client probes; the server answers. A probe carries whether its sender receives datagrams of the
//    other end, so both ends know the state of both directions.
// 2. Probes and answers are as large as the largest state: a path that passes them passes every state.
// 3. Silence for kPathSilence means that the path is gone; probing goes on, so state returns when the path
//    does.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "sync/transport/seal.h"
#include "sync/wire/limits.h"
#include "sync/wire/time.h"

namespace tandem::sync {

inline constexpr std::size_t kMaxDatagramBytes = kMaxStateBytes + kSealOverheadBytes;
inline constexpr Micros kProbeBurst = kSecond;            // how long a new client probes often
inline constexpr Micros kProbeOften = 50 * kMillisecond;  // while nothing is known
/// Keeps the path, and any address translation on it, open.
inline constexpr Micros kProbeSeldom = 500 * kMillisecond;
/// Half of a lease (LeaseRules), so that pings, which are state too, change to TLS before the lease expires.
inline constexpr Micros kPathSilence = kSecond;

/// What the exporter of a TLS session gives: a key for each direction.
struct StateKeys {
  SealKey clientToServer, serverToClient;
};

class StateChannel {
 public:
  enum class Side : std::uint8_t { client, server };
  StateChannel(Side side, SealAlgorithm algorithm, const StateKeys& keys, std::uint64_t wireId, Micros now);

  std::uint64_t wireId() const { return wireId_; }
  /// Whether state that is sent now will arrive, as far as is known.
  bool usable() const { return usable_; }
  /// Marks the path as gone after kPathSilence.
  void update(Micros now);

  /// Seals into `out` (kMaxDatagramBytes); 0: the key is used up and the connection must end.
  [[nodiscard]] std::size_t sealState(std::span<const std::byte> plain, std::byte* out);
  /// The client's probe if one is due, else 0.
  [[nodiscard]] std::size_t probeIfDue(Micros now, std::byte* out);

  struct Received {
    Opener::Verdict verdict = Opener::Verdict::forged;
    bool isState = false;  // `out` holds `size` bytes of state
    std::size_t size = 0;
    bool newest = false;         // the datagram shows the sender's current address
    std::size_t replyBytes = 0;  // a datagram to send back, in `reply`
  };
  /// `out` and `reply` have room for kMaxDatagramBytes each.
  [[nodiscard]] Received receive(std::span<const std::byte> datagram, Micros now, std::byte* out,
                                 std::byte* reply);

 private:
  std::size_t sealProbe(DatagramKind kind, std::byte* out);

  Side side_;
  std::uint64_t wireId_;
  Sealer sealer_;
  Opener opener_;
  Micros started_, lastReceived_, nextProbe_;
  bool receiving_ = false;  // a datagram of the other end arrived within kPathSilence
  bool usable_ = false;
};

}  // namespace tandem::sync
