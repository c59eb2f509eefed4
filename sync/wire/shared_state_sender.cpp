#include "sync/wire/shared_state_sender.h"

#include <algorithm>

#include "assets/base/assert.h"
#include "sync/wire/limits.h"
#include "sync/wire/state_sender.h"

namespace tandem::sync {
namespace {

constexpr std::uint32_t kFarthest = (1u << kDistanceBits) - 1;

bool sameCamera(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation == b.orientation;
}

}  // namespace

// ---- SharedReceiver ----

SharedReceiver::Origin& SharedReceiver::origin(std::size_t slot, std::uint32_t generation) {
  if (slot >= origins_.size()) origins_.resize(slot + 1);
  Origin& origin = origins_[slot];
  if (origin.generation != generation) origin = {.generation = generation};
  return origin;
}

void SharedReceiver::sent(const SentKey& key) {
  if (sent_.empty()) sent_.resize(kSentKeys);
  sent_[sentCount_++ % kSentKeys] = key;
}

void SharedReceiver::acknowledged(const StateAck& ack) {
  const std::uint32_t held = std::min(sentCount_, kSentKeys), first = sentCount_ - held;
  for (std::size_t i = 0; i < ack.count; ++i) {
    std::uint32_t low = 0, high = held;
    while (low < high) {
      const std::uint32_t middle = (low + high) / 2;
      if (isNewer(ack.sequences[i], sent_[(first + middle) % kSentKeys].sequence))
        low = middle + 1;
      else
        high = middle;
    }
    if (low == held) continue;
    const SentKey& key = sent_[(first + low) % kSentKeys];
    if (key.sequence != ack.sequences[i] || key.slot >= origins_.size()) continue;
    Origin& origin = origins_[key.slot];
    if (origin.generation != key.generation || !isNewer(key.key, origin.key)) continue;
    origin.key = key.key;
    origin.sequence = key.sequence;
  }
}

// ---- SharedStateSender ----

std::size_t SharedStateSender::slotOf(SiteId site) {
  ASSERT(site != kNoSite);
  std::size_t free = origins_.size();
  for (std::size_t i = 0; i < origins_.size(); ++i) {
    if (origins_[i].site == site) return i;
    if (origins_[i].site == kNoSite) free = std::min(free, i);
  }
  if (free == origins_.size()) origins_.emplace_back();
  origins_[free].site = site;
  return free;
}

void SharedStateSender::forget(SiteId site) {
  for (Origin& origin : origins_) {
    if (origin.site != site) continue;
    const std::uint32_t generation = origin.generation + 1;
    origin = {};
    origin.generation = generation;
  }
}

/// Presence where it is new. Its camera only where all get it: in the first presences after it moved, and in
/// every kCameraEvery-th.
StateWriter::With SharedStateSender::chooseForAll(Origin& origin, bool toAll) const {
  if (!update_->presenceKnown || !update_->newPresence) return {};
  StateWriter::With with{true, false, update_->presence.worldFromSecondTool.has_value()};
  if (!toAll) return with;
  const Pose& camera = update_->presence.worldFromCamera;
  if (!sameCamera(camera, origin.camera)) origin.presences = 0;
  with.camera = origin.presences < kCameraAtFirst || origin.presences % kCameraEvery == 0;
  ++origin.presences;
  origin.camera = camera;
  return with;
}

void SharedStateSender::begin(const StateUpdate& update, const WireFrame& frame, bool toAll) {
  ASSERT(update.parts.size() <= kMaxSharedParts);
  update_ = &update;
  frame_ = frame;
  variantCount_ = 0;
  slot_ = slotOf(update.site);
  Origin& origin = origins_[slot_];
  with_ = chooseForAll(origin, toAll);
  writer_.load(update, frame);
  isKey_ = toAll && !writer_.empty() &&
           (origin.lastKey == 0 || update.time - origin.keyAt >= kKeyInterval || update.time < origin.keyAt);
  if (!isKey_) return;
  origin.keyAt = update.time;
  Key& key = origin.keys[++origin.lastKey % kKeys];
  key.number = origin.lastKey;
  key.content.time = update.time;
  writer_.wholeBaseline(key.content.parts);
}

/// The key that the update may be encoded against for this receiver, or null.
const SharedStateSender::Key* SharedStateSender::keyFor(const SharedReceiver::Origin& receiver,
                                                        std::uint32_t sequence) const {
  if (isKey_ || receiver.key == 0 || writer_.empty()) return nullptr;
  const Key& key = origins_[slot_].keys[receiver.key % kKeys];
  const std::uint32_t distance = sequence - receiver.sequence;
  const Micros elapsed = update_->time - key.content.time;
  const bool usable = key.number == receiver.key && distance > 0 && distance <= kFarthest && elapsed > 0 &&
                      elapsed <= kLongestKeyAge && writer_.stepFrom(key.content);
  return usable ? &key : nullptr;
}

SharedStateSender::Variant& SharedStateSender::variant(const Key* key, StateWriter::With with) {
  const std::uint32_t number = key != nullptr ? key->number : 0;
  for (std::size_t i = 0; i < variantCount_; ++i)
    if (variants_[i].key == number && variants_[i].with == with) return variants_[i];
  // With more kinds of receivers than that the last place is used again.
  if (variantCount_ < kMaxVariants) ++variantCount_;
  if (variants_.size() < variantCount_) variants_.emplace_back();
  Variant& made = variants_[variantCount_ - 1];
  made.key = number;
  made.with = with;
  EncodeLosses ignored;
  writer_.write(*update_, key != nullptr ? &key->content : nullptr, isKey_, with, frame_, made.bytes,
                ignored);
  ASSERT(ignored.leftOut + static_cast<int>(kMaxSharedParts) >= 0);
  ++encodings_;
  return made;
}

std::span<const std::byte> SharedStateSender::encodeFor(SharedReceiver& receiver, std::uint32_t sequence) {
  ASSERT(update_ != nullptr);
  const std::uint32_t generation = origins_[slot_].generation;
  SharedReceiver::Origin& known = receiver.origin(slot_, generation);
  StateWriter::With with = with_;
  if (update_->presenceKnown && known.presences < kCameraAtFirst) {
    ++known.presences;
    with = {true, true, update_->presence.worldFromSecondTool.has_value()};
  }
  const Key* key = keyFor(known, sequence);
  Variant& made = variant(key, with);
  replaceBits(made.bytes, StateWriter::kSequenceBit, sequence, 32);
  if (key != nullptr)
    replaceBits(made.bytes, StateWriter::kDistanceBit, sequence - known.sequence, kDistanceBits);
  if (isKey_)
    receiver.sent({sequence, generation, origins_[slot_].lastKey, static_cast<std::uint32_t>(slot_)});
  return made.bytes;
}

}  // namespace tandem::sync
