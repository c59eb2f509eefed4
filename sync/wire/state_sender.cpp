#include "sync/wire/state_sender.h"

#include "assets/base/assert.h"
#include "sync/wire/limits.h"

namespace tandem::sync {
namespace {

constexpr std::uint32_t kFarthestKept = (1u << kDistanceBits) - 1;

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
    if (!kept.acknowledged || distance == 0 || distance > kFarthestKept || elapsed <= 0 ||
        elapsed > kLongestElapsed)
      continue;
    if (best == nullptr || isNewer(kept.sequence, best->sequence)) best = &kept;
  }
  return best;
}

void StateSender::keep(Stream& stream, const StateUpdate& update, Micros elapsed) {
  // The slot may hold the baseline itself, which is read before it is replaced.
  writer_.baselineOf(elapsed, spare_);
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
StateWriter::With StateSender::Stream::choose(const StateUpdate& update) {
  if (!update.presenceKnown || (!update.newPresence && presences > 0)) return {};
  const Pose& now = update.presence.worldFromCamera;
  const bool moved = now.position != camera.position || now.orientation != camera.orientation;
  if (moved) presences = 0;
  const StateWriter::With with{true, presences < kCameraAtFirst || presences % kCameraEvery == 0,
                               update.presence.worldFromSecondTool.has_value()};
  ++presences;
  camera = now;
  return with;
}

void StateSender::encode(const StateUpdate& update, const WireFrame& frame, std::vector<std::byte>& bytes,
                         EncodeLosses* losses) {
  EncodeLosses counted;
  Stream& stream = streamOf(update.site);
  writer_.load(update, frame);
  const KeptUpdate* baseline = writer_.empty() ? nullptr : baselineFor(stream, update);
  if (baseline != nullptr && !writer_.stepFrom(*baseline)) baseline = nullptr;
  const Micros elapsed = baseline != nullptr ? update.time - baseline->time : 0;
  const bool keeps = !writer_.empty() && (!stream.everKept || update.time - stream.keptAt >= kKeepInterval ||
                                          update.time < stream.keptAt);
  writer_.write(update, baseline, keeps, stream.choose(update), frame, bytes, counted);
  if (keeps) keep(stream, update, elapsed);
  if (losses != nullptr) *losses = counted;
}

}  // namespace tandem::sync
