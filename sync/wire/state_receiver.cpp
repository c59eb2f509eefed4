#include "sync/wire/state_receiver.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

/// Slots for reordering: a newer marked datagram may overtake one whose baseline it displaces.
constexpr std::size_t kReceiverSpare = 8;

}  // namespace

void StateReceiver::reset() {
  streams_.clear();
  ack_.count = 0;
}

void StateReceiver::forget(SiteId origin) {
  std::erase_if(streams_, [&](const Stream& stream) { return stream.origin == origin; });
}

StateReceiver::Stream* StateReceiver::streamOf(SiteId origin) {
  if (origins_ == 1) origin = kNoSite;
  if (Stream* known = findStream(streams_, origin)) return known;
  if (streams_.size() == origins_) return nullptr;
  Stream& stream = streams_.emplace_back();
  stream.origin = origin;
  return &stream;
}

StateReceiver::Outcome StateReceiver::decode(std::span<const std::byte> bytes, const WireFrame& frame,
                                             StateMessage& message) {
  const bool streamed = bytes.size() > 1 && bytes[1] == static_cast<std::byte>(StateKind::streamed);
  if (!streamed) return decodeState(bytes, frame, message).ok() ? Outcome::decoded : Outcome::malformed;
  if (bytes.size() > kMaxStateBytes) return Outcome::malformed;
  BitReader reader(bytes);
  if (reader.get(8) != kStateVersion) return Outcome::malformed;
  reader.get(8);
  auto* update = std::get_if<StateUpdate>(&message);
  if (update == nullptr) update = &message.emplace<StateUpdate>();
  return decodeUpdate(reader, frame, *update);
}

/// Reads the parts that are differences to the baseline.
StateReceiver::Outcome StateReceiver::readAgainst(BitReader& reader, const KeptUpdate& baseline,
                                                  Micros elapsed, std::uint32_t step,
                                                  const WireFrame& frame) {
  for (const PartBaseline& known : baseline.parts) {
    if (reader.failed()) return Outcome::malformed;
    PartCode code = known.code;
    code.sequence += step;
    DeltaOrders orders = known.orders;
    if (reader.get(1) == 1) {
      if (reader.get(1) == 1) continue;
      orders = getDelta(reader, known, elapsed, frame, code);
    } else if (!code.twist.still()) {
      reader.fail();  // a part in motion cannot be encoded as unchanged
    }
    parts_.push_back(encodedAgainst(known, elapsed, code, orders));
  }
  return reader.failed() ? Outcome::malformed : Outcome::decoded;
}

StateReceiver::Outcome StateReceiver::readWhole(BitReader& reader) {
  const std::size_t count = reader.get(8);
  // A count is trusted only if the datagram has bits for so many parts.
  if (count * kSmallestPartBits > reader.remaining()) return Outcome::malformed;
  for (std::size_t i = 0; i < count; ++i) {
    const PartCode code = getWhole(reader);
    for (const PartBaseline& other : parts_)
      if (other.code.part == code.part) return Outcome::malformed;
    parts_.push_back({code, false, {}, 0, {}});
  }
  return reader.failed() || !reader.atEnd() ? Outcome::malformed : Outcome::decoded;
}

StateReceiver::Outcome StateReceiver::decodeUpdate(BitReader& reader, const WireFrame& frame,
                                                   StateUpdate& update) {
  update.site = static_cast<SiteId>(reader.get(16));
  update.sequence = static_cast<std::uint32_t>(reader.get(32));
  const bool keeps = reader.get(1) == 1;
  update.newPresence = reader.get(1) == 1;
  const bool against = reader.get(1) == 1, camera = reader.get(1) == 1;
  const bool second = reader.get(1) == 1;
  if (reader.failed() || ((camera || second) && !update.newPresence)) return Outcome::malformed;
  Stream* stream = streamOf(update.site);
  if (stream == nullptr) return Outcome::malformed;

  const KeptUpdate* baseline = nullptr;
  Micros elapsed = 0;
  std::uint32_t step = 0;
  std::uint64_t expected = 0;
  if (against) {
    const std::uint32_t sequence = update.sequence - static_cast<std::uint32_t>(reader.get(kDistanceBits));
    elapsed = static_cast<Micros>(reader.get(kElapsedBits));
    step = reader.getVarint();
    expected = reader.get(kCheckBits);
    if (reader.failed() || sequence == update.sequence || elapsed == 0) return Outcome::malformed;
    for (const KeptUpdate& kept : stream->kept)
      if (kept.sequence == sequence) baseline = &kept;
    if (baseline == nullptr) return Outcome::noBaseline;
    update.time = baseline->time + elapsed;
    if (update.time > kMaxMicros) return Outcome::malformed;
  } else {
    update.time = getTime(reader);
  }
  if (update.newPresence) {
    update.presence.worldFromCamera = stream->camera;
    getPresence(reader, frame, camera, update.presence);
    update.presence.worldFromSecondTool.reset();
    if (second) getSecondTool(reader, frame, update.presence);
    update.newPresence = camera || stream->hasCamera;  // a hand is not displayed before its camera is known
  }

  parts_.clear();
  if (baseline != nullptr)
    if (const Outcome read = readAgainst(reader, *baseline, elapsed, step, frame); read != Outcome::decoded)
      return read;
  if (const Outcome read = readWhole(reader); read != Outcome::decoded) return read;
  StateChecksum check;
  update.parts.resize(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    check.add(parts_[i].code);
    if (!fromCode(parts_[i].code, frame, update.parts[i])) return Outcome::malformed;
  }
  if (baseline != nullptr && check.value() != expected) return Outcome::checksumMismatch;
  completePresence(*stream, camera, update);
  if (keeps) keep(*stream, update);
  return Outcome::decoded;
}

void StateReceiver::completePresence(Stream& stream, bool camera, StateUpdate& update) {
  if (camera && (!stream.hasCamera || isNewer(update.sequence, stream.cameraSequence))) {
    stream.hasCamera = true;
    stream.cameraSequence = update.sequence;
    stream.camera = update.presence.worldFromCamera;
  }
  if (update.newPresence && (!stream.hasPresence || isNewer(update.sequence, stream.presenceSequence))) {
    stream.hasPresence = true;
    stream.presenceSequence = update.sequence;
    stream.presence = update.presence;
  }
  if (!update.newPresence) update.presence = stream.presence;
  update.presence.site = update.site;
  update.presenceKnown = stream.hasPresence;
}

/// Keeps the newest marked datagrams. One that arrived twice, or is older than all that are kept, is ignored.
void StateReceiver::keep(Stream& stream, const StateUpdate& update) {
  KeptUpdate* slot = nullptr;
  for (KeptUpdate& kept : stream.kept)
    if (kept.sequence == update.sequence) return;
  if (stream.kept.size() < kKept + kReceiverSpare) {
    slot = &stream.kept.emplace_back();
  } else {
    slot = &*std::min_element(
        stream.kept.begin(), stream.kept.end(),
        [](const KeptUpdate& a, const KeptUpdate& b) { return isNewer(b.sequence, a.sequence); });
    if (isNewer(slot->sequence, update.sequence)) return;
  }
  ASSERT(stream.kept.size() <= kKept + kReceiverSpare);
  slot->sequence = update.sequence;
  slot->time = update.time;
  slot->parts = parts_;
  if (ack_.count < StateAck::kMax) ack_.sequences[ack_.count++] = update.sequence;
}

std::optional<StateAck> StateReceiver::drainAck(Micros now) {
  const Micros interval = streams_.size() > kManyOrigins ? kCrowdAckInterval : kAckInterval;
  if (ack_.count == 0 || (everAcknowledged_ && now - acknowledgedAt_ < interval)) return std::nullopt;
  everAcknowledged_ = true;
  acknowledgedAt_ = now;
  ASSERT(ack_.count <= StateAck::kMax);
  const StateAck ack = ack_;
  ack_.count = 0;
  return ack;
}

}  // namespace tandem::sync
