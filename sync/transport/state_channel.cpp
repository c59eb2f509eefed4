#include "sync/transport/state_channel.h"

#include <array>

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
      lastHeard_(now),
      nextProbe_(now) {}

void StateChannel::update(Micros now) {
  if (heard_ && now - lastHeard_ > kPathSilence) heard_ = usable_ = false;
}

std::size_t StateChannel::sealState(std::span<const std::byte> plain, std::byte* out) {
  return sealer_.seal(DatagramKind::state, plain, out);
}

std::size_t StateChannel::sealProbe(DatagramKind kind, std::byte* out) {
  std::array<std::byte, kMaxStateBytes> plain{};
  plain[0] = heard_ ? std::byte{1} : std::byte{0};
  return sealer_.seal(kind, plain, out);
}

std::size_t StateChannel::probeIfDue(Micros now, std::byte* out) {
  if (side_ != Side::client || now < nextProbe_) return 0;
  const bool often = !heard_ && now - started_ < kProbeBurst;
  nextProbe_ = now + (often ? kProbeOften : kProbeSeldom);
  return sealProbe(DatagramKind::probe, out);
}

StateChannel::Received StateChannel::receive(std::span<const std::byte> datagram, Micros now, std::byte* out,
                                             std::byte* reply) {
  const Opener::Opened opened = opener_.open(datagram, out);
  Received received{.verdict = opened.verdict, .newest = opened.newest};
  if (opened.verdict != Opener::Verdict::accepted) return received;
  lastHeard_ = now;
  const bool firstHeard = !heard_;
  heard_ = true;
  if (opened.kind == DatagramKind::state) {
    // A sender uses this path only once it knows that it is heard; its own probes say so, too, but may be
    // late.
    usable_ = true;
    received.isState = true;
    received.size = opened.size;
  } else if (opened.kind == DatagramKind::answer) {
    usable_ = true;
    // Tell the server at once that the way back works, instead of at the next probe.
    if (firstHeard) received.replyBytes = sealProbe(DatagramKind::probe, reply);
  } else if (side_ == Side::server) {
    if (opened.newest && opened.size > 0) usable_ = out[0] != std::byte{0};
    received.replyBytes = sealProbe(DatagramKind::answer, reply);
  }
  return received;
}

}  // namespace tandem::sync
