#include "sync/transport/state_channel.h"

#include <array>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

const SealKey& keyToSend(StateChannel::Side side, const StateKeys& keys) {
  return side == StateChannel::Side::client ? keys.clientToServer : keys.serverToClient;
}
const SealKey& keyToReceive(StateChannel::Side side, const StateKeys& keys) {
  return side == StateChannel::Side::client ? keys.serverToClient : keys.clientToServer;
}

}  // namespace

StateChannel::StateChannel(Side side, SealAlgorithm algorithm, const StateKeys& keys, std::uint64_t wireId,
                           Micros now)
    : side_(side),
      wireId_(wireId),
      sealer_(algorithm, keyToSend(side, keys), wireId),
      opener_(algorithm, keyToReceive(side, keys), wireId),
      started_(now),
      lastReceived_(now),
      nextProbe_(now) {}

void StateChannel::update(Micros now) {
  if (receiving_ && now - lastReceived_ > kPathSilence) receiving_ = usable_ = false;
}

std::size_t StateChannel::sealState(std::span<const std::byte> plain, std::byte* out) {
  return sealer_.seal(DatagramKind::state, plain, out);
}

std::size_t StateChannel::sealProbe(DatagramKind kind, std::byte* out) {
  std::array<std::byte, kMaxStateBytes> plain{};
  ASSERT(kind != DatagramKind::state);
  plain[0] = receiving_ ? std::byte{1} : std::byte{0};
  const std::size_t size = sealer_.seal(kind, plain, out);
  ASSERT(size <= kMaxDatagramBytes);
  return size;
}

std::size_t StateChannel::probeIfDue(Micros now, std::byte* out) {
  if (side_ != Side::client || now < nextProbe_) return 0;
  const bool often = !receiving_ && now - started_ < kProbeBurst;
  nextProbe_ = now + (often ? kProbeOften : kProbeSeldom);
  return sealProbe(DatagramKind::probe, out);
}

StateChannel::Received StateChannel::receive(std::span<const std::byte> datagram, Micros now, std::byte* out,
                                             std::byte* reply) {
  const Opener::Opened opened = opener_.open(datagram, out);
  Received received{.verdict = opened.verdict, .newest = opened.newest};
  if (opened.verdict != Opener::Verdict::accepted) return received;
  ASSERT(opened.size + kSealOverheadBytes == datagram.size());
  lastReceived_ = now;
  const bool first = !receiving_;
  receiving_ = true;
  if (opened.kind == DatagramKind::state) {
    // A sender uses this path only once it knows that its datagrams arrive. Its probes carry the same
    // information, but may arrive later.
    usable_ = true;
    received.isState = true;
    received.size = opened.size;
  } else if (opened.kind == DatagramKind::answer) {
    usable_ = true;
    // The server learns at once, instead of at the next probe, that its datagrams arrive.
    if (first) received.replyBytes = sealProbe(DatagramKind::probe, reply);
  } else if (side_ == Side::server) {
    if (opened.newest && opened.size > 0) usable_ = out[0] != std::byte{0};
    received.replyBytes = sealProbe(DatagramKind::answer, reply);
  }
  return received;
}

}  // namespace tandem::sync
