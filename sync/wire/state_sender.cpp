#include "sync/wire/state_sender.h"

#include "assets/base/assert.h"
#include "sync/wire/limits.h"

namespace tandem::sync {
namespace {

constexpr int kHeadBits = 8 + 8 + 16 + 32 + 1 + 1 + 1 + 1 + 1;
/// Presences with a camera at rest, since datagrams get lost.
constexpr int kCameraAtFirst = 4, kCameraEvery = 8;
constexpr std::uint32_t kFarthest = (1u << kDistanceBits) - 1;

bool unmoved(const PartCode& before, const PartCode& now) {
  return now.twist.still() && before.twist.still() && now.pose == before.pose;
}

}  // namespace

StateSender::Stream& StateSender::streamOf(SiteId origin) {
  if (Stream* known = findStream(streams_, origin)) return *known;
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
    if (best == nullptr || isNewer(kept.sequence, best->sequence)) best = &kept;
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
  std::size_t encoded = 0;
  for (std::size_t i = 0; i < codes_.size() && encoded < kMaxStateParts; ++i) {
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
    ++encoded;
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
  writer.put(with.second ? 1 : 0, 1);
  if (baseline == nullptr) {
    putTime(writer, update.time);
  } else {
    StateChecksum check;
    for (const Plan& plan : plans_)
      if (plan.code >= 0) check.add(codes_[static_cast<std::size_t>(plan.code)]);
    for (const std::size_t i : whole_) check.add(codes_[i]);
    writer.put(update.sequence - baseline->sequence, kDistanceBits);
    writer.put(static_cast<std::uint64_t>(update.time - baseline->time), kElapsedBits);
    writer.putVarint(step);
    writer.put(check.value(), kCheckBits);
  }
  if (with.presence) putPresence(writer, update.presence, with.camera, frame, losses.clamped);
  if (with.second) putSecondTool(writer, update.presence, frame, losses.clamped);
  for (Plan& plan : plans_) {
    const bool encoded = plan.code >= 0;
    writer.put(encoded && plan.same ? 0 : 1, 1);
    if (encoded && plan.same) continue;
    writer.put(encoded ? 0 : 1, 1);
    if (!encoded) continue;
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
          encodedAgainst(*plan.baseline, elapsed, codes_[static_cast<std::size_t>(plan.code)], plan.orders));
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

/// Whether presence and camera go into this update: the presence where it is new, or new to this receiver;
/// the camera in the first presences after it moved and then in every kCameraEvery-th, because datagrams get
/// lost.
StateSender::With StateSender::Stream::choose(const StateUpdate& update) {
  if (!update.presenceKnown || (!update.newPresence && presences > 0)) return {};
  const Pose& now = update.presence.worldFromCamera;
  const bool moved = now.position != camera.position || now.orientation != camera.orientation;
  if (moved) presences = 0;
  const With with{true, presences < kCameraAtFirst || presences % kCameraEvery == 0,
                  update.presence.worldFromSecondTool.has_value()};
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
  const With with = stream.choose(update);
  const int head =
      kHeadBits + 8 + (with.presence ? (with.camera ? kPresenceBits : kHandBits) : 0) +
      (with.second ? kPoseBits : 0) +
      (baseline != nullptr ? kDistanceBits + kElapsedBits + varintBits(*step) + kCheckBits : kTimeBits);
  plan(baseline, elapsed, step, frame, static_cast<int>(kMaxStateBytes) * 8 - head);
  const bool keeps = !codes_.empty() && (!stream.everKept || update.time - stream.keptAt >= kKeepInterval ||
                                         update.time < stream.keptAt);
  write(update, baseline, step.value_or(0), keeps, with, frame, bytes, counted);
  std::size_t encoded = whole_.size();
  for (const Plan& plan : plans_) encoded += plan.code >= 0 ? 1 : 0;
  counted.leftOut += static_cast<int>(update.parts.size() - encoded);
  ASSERT(counted.leftOut >= 0 && bytes.size() <= kMaxStateBytes);
  if (keeps) keep(stream, update, elapsed);
  if (losses != nullptr) *losses = counted;
}

}  // namespace tandem::sync
