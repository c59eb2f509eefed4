// Bytes from a peer: whatever they are, decoding ends, and what it accepts can be encoded again.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "sync/link_stream.h"
#include "sync/wire.h"

namespace {

using namespace tandem::sync;
const WireFrame kFrame{{0.1, 0.2, 0.3}, 4.0};

void control(std::span<const std::byte> bytes) {
  const auto message = decodeControl(bytes);
  if (!message.ok()) return;
  const auto* hello = std::get_if<Hello>(&*message);
  if (hello != nullptr && hello->protocolVersion != kProtocolVersion) return;
  const auto again = encodeControl(*message);
  if (again.size() != bytes.size() || !std::equal(again.begin(), again.end(), bytes.begin())) std::abort();
}

void state(std::span<const std::byte> bytes) {
  StateMessage message;
  if (!decodeState(bytes, kFrame, message).ok()) return;
  if (const auto* update = std::get_if<StateUpdate>(&message)) {
    for (const PartState& part : update->parts) {
      if (!tandem::isValid(part.worldFromPart)) std::abort();
    }
  }
  if (const auto* link = std::get_if<LinkUpdate>(&message)) {
    if (!tandem::isValid(link->worldFromDrawn) || link->regime > 2) std::abort();
    LinkReceiver receiver;
    for (const Micros now : {Micros{0}, kMaxMicros / 2}) {
      const auto whole = receiver.receive(*link, now);
      if (whole && (!tandem::isValid(whole->worldFromDrawn) || !(whole->energy >= 0.0))) std::abort();
    }
  }
  std::vector<std::byte> again;
  encodeState(message, kFrame, again);
  StateMessage second;
  if (!decodeState(again, kFrame, second).ok()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(1);
  if (data[0] % 2 == 0) {
    control(bytes);
  } else {
    state(bytes);
  }
  return 0;
}
