// Bytes from a peer: whatever they are, decoding ends, and what it accepts can be encoded again.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "sync/wire/link_stream.h"
#include "sync/wire/state_bundle.h"
#include "sync/wire/state_receiver.h"
#include "sync/wire/state_sender.h"
#include "sync/wire/traffic.h"
#include "sync/wire/wire.h"

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

/// A receiver that has something to be told against: an update of two parts, kept under sequence 1 of site 3.
StateReceiver begun() {
  StateUpdate update;
  update.site = 3;
  update.sequence = 1;
  update.parts.resize(2);
  update.parts[0].part = 4;
  update.parts[0].twist = {{0.1, 0.0, 0.2}, {1.0, 0.0, 0.0}};
  update.parts[1].part = 5;
  std::vector<std::byte> bytes;
  StateSender().encode(update, kFrame, bytes);
  StateReceiver receiver;
  StateMessage message;
  if (receiver.decode(bytes, kFrame, message) != StateReceiver::Outcome::decoded) std::abort();
  return receiver;
}

/// The bytes as they are, and told against what the receiver has: `bytes` then follow a head that says so.
void streamed(std::span<const std::byte> bytes) {
  StateReceiver receiver = begun();
  StateMessage message;
  Traffic traffic;
  traffic.countState(bytes);
  for (const bool headed : {false, true}) {
    std::vector<std::byte> datagram;
    if (headed)
      for (const int byte : {int{kStateVersion}, 5, 3, 0, 2, 0, 0, 0, 0x25, 0, 0})
        datagram.push_back(static_cast<std::byte>(byte));
    datagram.insert(datagram.end(), bytes.begin(), bytes.end());
    if (receiver.decode(datagram, kFrame, message) != StateReceiver::Outcome::decoded) continue;
    if (const auto* update = std::get_if<StateUpdate>(&message))
      for (const PartState& part : update->parts)
        if (!tandem::isValid(part.worldFromPart) || part.part >= tandem::kMaxParts) std::abort();
  }
}

/// As a difference alone, without the check that a stream has.
void difference(std::span<const std::byte> bytes) {
  PartBaseline baseline;
  baseline.code.part = 1;
  baseline.hasBefore = true;
  baseline.sinceBefore = 1;
  baseline.before.linear = {32767, -32767, 1};
  BitReader reader(bytes);
  PartCode code = baseline.code;
  getDelta(reader, baseline, kLongestElapsed, kFrame, code);
  if (reader.failed()) return;
  PartState state;
  if (!fromCode(code, kFrame, state) || !tandem::isValid(state.worldFromPart)) std::abort();
  std::vector<std::byte> again(400);
  BitWriter writer(again);
  putDelta(writer, baseline, kLongestElapsed, code, kFrame);
  PartCode second = baseline.code;
  BitReader back(again);
  getDelta(back, baseline, kLongestElapsed, kFrame, second);
  if (back.failed() || !(second == code)) std::abort();
}

/// Every message of a datagram, as often as there is one.
void bundled(std::span<const std::byte> bytes) {
  std::size_t most = bytes.size();
  do {
    const std::span<const std::byte> message = popMessage(bytes);
    if (message.size() > most || bytes.size() + message.size() > most) std::abort();
    most = bytes.size();
    state(message);
  } while (!bytes.empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(1);
  if (data[0] % 2 == 0) {
    control(bytes);
  } else {
    bundled(bytes);
    streamed(bytes);
    difference(bytes);
  }
  return 0;
}
