#include "sync/wire/state_stream.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

constexpr int kDistanceBits = 16, kCheckBits = 16;
constexpr int kHeadBits = 8 + 8 + 16 + 32 + 1 + 1 + 1 + 1;
constexpr int kCameraAtFirst = 4, kCameraEvery = 8;  // presences, of eyes that are still: datagrams get lost
constexpr std::uint32_t kFarthest = (1u << kDistanceBits) - 1;
constexpr std::size_t kReceiverSpare =
    8;  // of reordering: a newer mark may come before what its baseline was for

/// A checksum of the states that the receiver must end up with: each number takes part, in the order of the
/// wire.
class Check {
 public:
  void add(const PartCode& code) {
    for (const std::uint64_t x :
         {std::uint64_t{code.part}, std::uint64_t{code.epoch}, std::uint64_t{code.sequence},
          static_cast<std::uint64_t>(code.pose.largest)})
      mix(x);
    for (const Code3* three :
         {&code.pose.position, &code.pose.three, &code.twist.linear, &code.twist.angular})
      for (const std::int64_t x : *three) mix(static_cast<std::uint64_t>(x));
  }
  std::uint64_t value() const { return state_ >> (64 - kCheckBits); }

 private:
  void mix(std::uint64_t x) { state_ = (state_ ^ x) * 0x9e3779b97f4a7c15u; }
  std::uint64_t state_ = 1;
};

template <typename Streams>
auto* find(Streams& streams, SiteId origin) {
  const auto at = std::find_if(streams.begin(), streams.end(),
                               [&](const auto& stream) { return stream.origin == origin; });
  return at == streams.end() ? nullptr : &*at;
}

bool newer(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) > 0; }

bool unmoved(const PartCode& before, const PartCode& now) {
  return now.twist.still() && before.twist.still() && now.pose == before.pose;
}

}  // namespace

// ---- sender ----

StateSender::Stream& StateSender::streamOf(SiteId origin) {
  if (Stream* known = find(streams_, origin)) return *known;
  Stream& stream = streams_.emplace_back();
  stream.origin = origin;
  return stream;
}

void StateSender::forget(SiteId origin) {
  std::erase_if(streams_, [&](const Stream& stream) { return stream.origin == origin; });
}

void StateSender::acknowledged(const StateAck& ack) {
  for (Stream& stream : streams_)
    for (KeptUpdate& kept : stream.kept)
      for (std::size_t i = 0; i < ack.count; ++i)
        if (ack.sequences[i] == kept.sequence) kept.acknowledged = true;
}

const KeptUpdate* StateSender::baselineFor(const Stream& stream, const StateUpdate& update) const {
  const KeptUpdate* best = nullptr;
  for (const KeptUpdate& kept : stream.kept) {
    const std::uint32_t distance = update.sequence - kept.sequence;
    const Micros elapsed = update.time - kept.time;
    if (!kept.acknowledged || distance == 0 || distance > kFarthest || elapsed <= 0 ||
        elapsed > kLongestElapsed)
      continue;
    if (best == nullptr || newer(kept.sequence, best->sequence)) best = &kept;
  }
  return best;
}

/// By how much the sequences of the parts have grown since the baseline; a site's parts all grow by the same.
std::optional<std::uint32_t> StateSender::stepFrom(const KeptUpdate& baseline) const {
  for (const PartBaseline& known : baseline.parts)
    for (const PartCode& code : codes_)
      if (code.part == known.code.part && code.epoch == known.code.epoch)
        return code.sequence - known.code.sequence;
  return std::nullopt;
}

/// Decides how each part is encoded, as long as there is room, in the order in which they were given.
void StateSender::plan(const KeptUpdate* baseline, Micros elapsed, std::optional<std::uint32_t> step,
                       const WireFrame& frame, int room) {
  plans_.clear();
  whole_.clear();
  if (baseline != nullptr)
    for (const PartBaseline& known : baseline->parts) plans_.push_back({&known, -1, false, known.orders});
  room -= 2 * static_cast<int>(plans_.size());
  std::size_t told = 0;
  for (std::size_t i = 0; i < codes_.size() && told < kMaxStateParts; ++i) {
    const PartCode& code = codes_[i];
    int bits = wholeBits(code);
    Plan* against = nullptr;
    for (Plan& candidate : plans_) {
      const PartCode& before = candidate.baseline->code;
      if (before.part != code.part || before.epoch != code.epoch || code.sequence - before.sequence != step)
        continue;
      const bool same = unmoved(before, code);
      const int fewer = same ? 0 : deltaBits(*candidate.baseline, elapsed, code, frame);
      if (fewer >= bits) continue;
      bits = fewer;
      against = &candidate;
      against->same = same;
    }
    if (bits > room) continue;
    room -= bits;
    ASSERT(room >= 0);
    ++told;
    if (against != nullptr)
      against->code = static_cast<int>(i);
    else
      whole_.push_back(i);
  }
}

void StateSender::write(const StateUpdate& update, const KeptUpdate* baseline, std::uint32_t step, bool keep,
                        With with, const WireFrame& frame, std::vector<std::byte>& bytes,
                        EncodeLosses& losses) {
  bytes.resize(kMaxStateBytes);
  BitWriter writer(bytes);
  writer.put(kStateVersion, 8);
  writer.put(static_cast<std::uint8_t>(StateKind::streamed), 8);
  writer.put(update.site, 16);
  writer.put(update.sequence, 32);
  writer.put(keep ? 1 : 0, 1);
  writer.put(with.presence ? 1 : 0, 1);
  writer.put(baseline != nullptr ? 1 : 0, 1);
  writer.put(with.camera ? 1 : 0, 1);
  if (baseline == nullptr) {
    putTime(writer, update.time);
  } else {
    Check check;
    for (const Plan& plan : plans_)
      if (plan.code >= 0) check.add(codes_[static_cast<std::size_t>(plan.code)]);
    for (const std::size_t i : whole_) check.add(codes_[i]);
    writer.put(update.sequence - baseline->sequence, kDistanceBits);
    writer.put(static_cast<std::uint64_t>(update.time - baseline->time), kElapsedBits);
    writer.putVarint(step);
    writer.put(check.value(), kCheckBits);
  }
  if (with.presence) putPresence(writer, update.presence, with.camera, frame, losses.clamped);
  for (Plan& plan : plans_) {
    const bool told = plan.code >= 0;
    writer.put(told && plan.same ? 0 : 1, 1);
    if (told && plan.same) continue;
    writer.put(told ? 0 : 1, 1);
    if (!told) continue;
    plan.orders = putDelta(writer, *plan.baseline, update.time - baseline->time,
                           codes_[static_cast<std::size_t>(plan.code)], frame);
  }
  writer.put(whole_.size(), 8);
  for (const std::size_t i : whole_) putWhole(writer, codes_[i]);
  ASSERT(!writer.overflowed());
  bytes.resize((writer.bitCount() + 7) / 8);
}

void StateSender::keep(Stream& stream, const StateUpdate& update, Micros elapsed) {
  // The slot may hold the baseline itself, which is read before it is replaced.
  spare_.clear();
  for (const Plan& plan : plans_)
    if (plan.code >= 0)
      spare_.push_back(
          toldAgainst(*plan.baseline, elapsed, codes_[static_cast<std::size_t>(plan.code)], plan.orders));
  for (const std::size_t i : whole_) spare_.push_back({codes_[i], false, {}, 0, {}});
  if (stream.kept.size() < kKept) {
    stream.next = stream.kept.size();
    stream.kept.emplace_back();
  }
  KeptUpdate& slot = stream.kept[stream.next];
  slot.sequence = update.sequence;
  slot.time = update.time;
  slot.acknowledged = false;
  slot.parts.swap(spare_);
  ASSERT(stream.kept.size() <= kKept && stream.next < stream.kept.size());
  stream.next = (stream.next + 1) % kKept;
  stream.everKept = true;
  stream.keptAt = update.time;
}

/// What else goes into this update: the presence if it is new, or new to this receiver; the camera a few
/// times after it moved, and then at times, because datagrams get lost.
StateSender::With StateSender::Stream::goesAlong(const StateUpdate& update) {
  if (!update.presenceKnown || (!update.newPresence && presences > 0)) return {};
  const Pose& now = update.presence.worldFromCamera;
  const bool moved = now.position != camera.position || now.orientation != camera.orientation;
  if (moved) presences = 0;
  const With with{true, presences < kCameraAtFirst || presences % kCameraEvery == 0};
  ++presences;
  camera = now;
  return with;
}

void StateSender::encode(const StateUpdate& update, const WireFrame& frame, std::vector<std::byte>& bytes,
                         EncodeLosses* losses) {
  EncodeLosses counted;
  Stream& stream = streamOf(update.site);
  codes_.clear();
  for (const PartState& state : update.parts)
    if (sendable(state)) codes_.push_back(toCode(state, frame, counted.clamped));
  const KeptUpdate* baseline = codes_.empty() ? nullptr : baselineFor(stream, update);
  const std::optional<std::uint32_t> step = baseline != nullptr ? stepFrom(*baseline) : std::nullopt;
  if (!step) baseline = nullptr;
  const Micros elapsed = baseline != nullptr ? update.time - baseline->time : 0;
  const With with = stream.goesAlong(update);
  const int head =
      kHeadBits + 8 + (with.presence ? (with.camera ? kPresenceBits : kHandBits) : 0) +
      (baseline != nullptr ? kDistanceBits + kElapsedBits + varintBits(*step) + kCheckBits : kTimeBits);
  plan(baseline, elapsed, step, frame, static_cast<int>(kMaxStateBytes) * 8 - head);
  const bool keeps = !codes_.empty() && (!stream.everKept || update.time - stream.keptAt >= kKeepInterval ||
                                         update.time < stream.keptAt);
  write(update, baseline, step.value_or(0), keeps, with, frame, bytes, counted);
  std::size_t told = whole_.size();
  for (const Plan& plan : plans_) told += plan.code >= 0 ? 1 : 0;
  counted.leftOut += static_cast<int>(update.parts.size() - told);
  ASSERT(counted.leftOut >= 0 && bytes.size() <= kMaxStateBytes);
  if (keeps) keep(stream, update, elapsed);
  if (losses != nullptr) *losses = counted;
}

// ---- receiver ----

void StateReceiver::reset() {
  streams_.clear();
  ack_.count = 0;
}

void StateReceiver::forget(SiteId origin) {
  std::erase_if(streams_, [&](const Stream& stream) { return stream.origin == origin; });
}

StateReceiver::Stream* StateReceiver::streamOf(SiteId origin) {
  if (origins_ == 1) origin = kNoSite;
  if (Stream* known = find(streams_, origin)) return known;
  if (streams_.size() == origins_) return nullptr;
  Stream& stream = streams_.emplace_back();
  stream.origin = origin;
  return &stream;
}

StateReceiver::Outcome StateReceiver::decode(std::span<const std::byte> bytes, const WireFrame& frame,
                                             StateMessage& message) {
  const bool streamed = bytes.size() > 1 && bytes[1] == static_cast<std::byte>(StateKind::streamed);
  if (!streamed) return decodeState(bytes, frame, message).ok() ? Outcome::taken : Outcome::malformed;
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
      reader.fail();  // a part that moves cannot be where it was
    }
    parts_.push_back(toldAgainst(known, elapsed, code, orders));
  }
  return reader.failed() ? Outcome::malformed : Outcome::taken;
}

StateReceiver::Outcome StateReceiver::readWhole(BitReader& reader) {
  const std::size_t count = reader.get(8);
  // A count is believed only if the datagram has bits for so many parts.
  if (count * kSmallestPartBits > reader.remaining()) return Outcome::malformed;
  for (std::size_t i = 0; i < count; ++i) {
    const PartCode code = getWhole(reader);
    for (const PartBaseline& other : parts_)
      if (other.code.part == code.part) return Outcome::malformed;
    parts_.push_back({code, false, {}, 0, {}});
  }
  return reader.failed() || !reader.atEnd() ? Outcome::malformed : Outcome::taken;
}

StateReceiver::Outcome StateReceiver::decodeUpdate(BitReader& reader, const WireFrame& frame,
                                                   StateUpdate& update) {
  update.site = static_cast<SiteId>(reader.get(16));
  update.sequence = static_cast<std::uint32_t>(reader.get(32));
  const bool keeps = reader.get(1) == 1;
  update.newPresence = reader.get(1) == 1;
  const bool against = reader.get(1) == 1, camera = reader.get(1) == 1;
  if (reader.failed() || (camera && !update.newPresence)) return Outcome::malformed;
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
    update.newPresence = camera || stream->hasCamera;  // a hand without eyes is not shown
  }

  parts_.clear();
  if (baseline != nullptr)
    if (const Outcome read = readAgainst(reader, *baseline, elapsed, step, frame); read != Outcome::taken)
      return read;
  if (const Outcome read = readWhole(reader); read != Outcome::taken) return read;
  Check check;
  update.parts.resize(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    check.add(parts_[i].code);
    if (!fromCode(parts_[i].code, frame, update.parts[i])) return Outcome::malformed;
  }
  if (baseline != nullptr && check.value() != expected) return Outcome::spoilt;
  takePresence(*stream, camera, update);
  if (keeps) keep(*stream, update);
  return Outcome::taken;
}

void StateReceiver::takePresence(Stream& stream, bool camera, StateUpdate& update) {
  if (camera && (!stream.hasCamera || newer(update.sequence, stream.cameraSequence))) {
    stream.hasCamera = true;
    stream.cameraSequence = update.sequence;
    stream.camera = update.presence.worldFromCamera;
  }
  if (update.newPresence && (!stream.hasPresence || newer(update.sequence, stream.presenceSequence))) {
    stream.hasPresence = true;
    stream.presenceSequence = update.sequence;
    stream.presence = update.presence;
  }
  if (!update.newPresence) update.presence = stream.presence;
  update.presence.site = update.site;
  update.presenceKnown = stream.hasPresence;
}

/// Keeps the newest datagrams. One that came twice, or is older than all that are kept, is not kept again.
void StateReceiver::keep(Stream& stream, const StateUpdate& update) {
  KeptUpdate* slot = nullptr;
  for (KeptUpdate& kept : stream.kept)
    if (kept.sequence == update.sequence) return;
  if (stream.kept.size() < kKept + kReceiverSpare) {
    slot = &stream.kept.emplace_back();
  } else {
    slot = &*std::min_element(
        stream.kept.begin(), stream.kept.end(),
        [](const KeptUpdate& a, const KeptUpdate& b) { return newer(b.sequence, a.sequence); });
    if (newer(slot->sequence, update.sequence)) return;
  }
  slot->sequence = update.sequence;
  slot->time = update.time;
  slot->parts = parts_;
  if (ack_.count < StateAck::kMost) ack_.sequences[ack_.count++] = update.sequence;
}

std::optional<StateAck> StateReceiver::takeAck(Micros now) {
  if (ack_.count == 0 || (everAcknowledged_ && now - acknowledgedAt_ < kAckInterval)) return std::nullopt;
  everAcknowledged_ = true;
  acknowledgedAt_ = now;
  const StateAck ack = ack_;
  ack_.count = 0;
  return ack;
}

}  // namespace tandem::sync
