#include "sync/wire/traffic.h"

#include "sync/wire/state_code.h"

namespace tandem::sync {
namespace {

constexpr std::size_t bytesOf(int bits) { return static_cast<std::size_t>((bits + 7) / 8); }
constexpr std::size_t kEmptyUpdate = bytesOf(8 + 8 + 16 + 32 + kTimeBits + kPresenceBits + 8);
constexpr int kEmptyStreamedBits = 8 + 8 + 16 + 32 + 5 + kTimeBits + 8;
constexpr std::size_t kFlags = 8;  // the byte of a streamed update that holds them

void count(Flow& flow, std::size_t bytes) {
  ++flow.packets;
  flow.bytes += bytes;
}

}  // namespace

void Traffic::countState(std::span<const std::byte> datagram) {
  const std::size_t size = datagram.size();
  bool hasParts = size > kEmptyUpdate;
  int presenceBits = kPresenceBits;
  switch (size > kFlags ? static_cast<StateKind>(datagram[1]) : StateKind{}) {
    case StateKind::ping:
    case StateKind::pong:
      return count(pings, size);
    case StateKind::link:
      return count(links, size);
    case StateKind::streamed: {
      const auto flags = std::to_integer<unsigned>(datagram[kFlags]);
      presenceBits = (flags & 2u) == 0 ? 0 : (flags & 8u) != 0 ? kPresenceBits : kHandBits;
      if ((flags & 16u) != 0) presenceBits += kPoseBits;
      const bool against = (flags & 4u) != 0;  // only an update with parts has a baseline
      hasParts = against || size > bytesOf(kEmptyStreamedBits + presenceBits);
      break;
    }
    case StateKind::updateOfTwoHands:
      hasParts = size > kEmptyUpdate + kPoseBits / 8;
      presenceBits += kPoseBits;
      break;
    case StateKind::update:
      break;
    default:
      return count(size > 1 && datagram[1] == static_cast<std::byte>(StateKind::ack) ? acks : unknown, size);
  }
  if (!hasParts) return count(presence, size);
  const std::size_t ofPresence = size > bytesOf(presenceBits) ? bytesOf(presenceBits) : 0;
  presence.bytes += ofPresence;
  count(parts, size - ofPresence);
}

void Traffic::countControl(std::size_t bytes) { count(control, bytes); }

void Traffic::add(const Traffic& other) {
  for (const auto& cause : kTrafficCauses) {
    (this->*cause.flow).packets += (other.*cause.flow).packets;
    (this->*cause.flow).bytes += (other.*cause.flow).bytes;
  }
}

}  // namespace tandem::sync
