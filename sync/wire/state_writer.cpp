#include "sync/wire/state_writer.h"

#include "assets/base/assert.h"
#include "sync/wire/limits.h"

namespace tandem::sync {
namespace {

constexpr int kHeadBits = 8 + 8 + 16 + 32 + 1 + 1 + 1 + 1 + 1;
static_assert(StateWriter::kDistanceBit == kHeadBits && StateWriter::kSequenceBit == 8 + 8 + 16);

bool unmoved(const PartCode& before, const PartCode& now) {
  return now.twist.still() && before.twist.still() && now.pose == before.pose;
}

}  // namespace

void StateWriter::load(const StateUpdate& update, const WireFrame& frame) {
  clamped_ = 0;
  codes_.clear();
  for (const PartState& state : update.parts)
    if (sendable(state)) codes_.push_back(toCode(state, frame, clamped_));
}

std::optional<std::uint32_t> StateWriter::stepFrom(const KeptUpdate& baseline) const {
  for (const PartBaseline& known : baseline.parts)
    for (const PartCode& code : codes_)
      if (code.part == known.code.part && code.epoch == known.code.epoch)
        return code.sequence - known.code.sequence;
  return std::nullopt;
}

/// Decides how each part is encoded, as long as there is room, in the order in which they were given.
void StateWriter::plan(const KeptUpdate* baseline, Micros elapsed, std::uint32_t step, const WireFrame& frame,
                       int room) {
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

void StateWriter::writeHead(BitWriter& writer, const StateUpdate& update, const KeptUpdate* baseline,
                            std::uint32_t step, bool keep, With with) const {
  writer.put(kStateVersion, 8);
  writer.put(static_cast<std::uint8_t>(StateKind::streamed), 8);
  writer.put(update.site, 16);
  writer.put(update.sequence, 32);
  writer.put(keep ? 1 : 0, 1);
  writer.put(with.presence ? 1 : 0, 1);
  writer.put(baseline != nullptr ? 1 : 0, 1);
  writer.put(with.camera ? 1 : 0, 1);
  writer.put(with.second ? 1 : 0, 1);
  if (baseline == nullptr) return putTime(writer, update.time);
  StateChecksum check;
  for (const Plan& plan : plans_)
    if (plan.code >= 0) check.add(codes_[static_cast<std::size_t>(plan.code)]);
  for (const std::size_t i : whole_) check.add(codes_[i]);
  writer.put(update.sequence - baseline->sequence, kDistanceBits);
  writer.put(static_cast<std::uint64_t>(update.time - baseline->time), kElapsedBits);
  writer.putVarint(step);
  writer.put(check.value(), kCheckBits);
}

void StateWriter::writeParts(BitWriter& writer, Micros elapsed, const WireFrame& frame) {
  for (Plan& plan : plans_) {
    const bool encoded = plan.code >= 0;
    writer.put(encoded && plan.same ? 0 : 1, 1);
    if (encoded && plan.same) continue;
    writer.put(encoded ? 0 : 1, 1);
    if (!encoded) continue;
    plan.orders =
        putDelta(writer, *plan.baseline, elapsed, codes_[static_cast<std::size_t>(plan.code)], frame);
  }
  writer.put(whole_.size(), 8);
  for (const std::size_t i : whole_) putWhole(writer, codes_[i]);
}

void StateWriter::write(const StateUpdate& update, const KeptUpdate* baseline, bool keep, With with,
                        const WireFrame& frame, std::vector<std::byte>& bytes, EncodeLosses& losses) {
  const std::uint32_t step = baseline != nullptr ? stepFrom(*baseline).value() : 0;
  const Micros elapsed = baseline != nullptr ? update.time - baseline->time : 0;
  const int head =
      kHeadBits + 8 + (with.presence ? (with.camera ? kPresenceBits : kHandBits) : 0) +
      (with.second ? kPoseBits : 0) +
      (baseline != nullptr ? kDistanceBits + kElapsedBits + varintBits(step) + kCheckBits : kTimeBits);
  plan(baseline, elapsed, step, frame, static_cast<int>(kMaxStateBytes) * 8 - head);
  losses = {0, clamped_};
  bytes.resize(kMaxStateBytes);
  BitWriter writer(bytes);
  writeHead(writer, update, baseline, step, keep, with);
  if (with.presence) putPresence(writer, update.presence, with.camera, frame, losses.clamped);
  if (with.second) putSecondTool(writer, update.presence, frame, losses.clamped);
  writeParts(writer, elapsed, frame);
  ASSERT(!writer.overflowed());
  bytes.resize((writer.bitCount() + 7) / 8);
  std::size_t encoded = whole_.size();
  for (const Plan& plan : plans_) encoded += plan.code >= 0 ? 1 : 0;
  losses.leftOut = static_cast<int>(update.parts.size() - encoded);
  ASSERT(losses.leftOut >= 0 && bytes.size() <= kMaxStateBytes);
}

void StateWriter::baselineOf(Micros elapsed, std::vector<PartBaseline>& parts) const {
  parts.clear();
  for (const Plan& plan : plans_)
    if (plan.code >= 0)
      parts.push_back(
          encodedAgainst(*plan.baseline, elapsed, codes_[static_cast<std::size_t>(plan.code)], plan.orders));
  for (const std::size_t i : whole_) parts.push_back({codes_[i], false, {}, 0, {}});
}

void StateWriter::wholeBaseline(std::vector<PartBaseline>& parts) const {
  parts.clear();
  for (const PartCode& code : codes_) parts.push_back({code, false, {}, 0, {}});
}

}  // namespace tandem::sync
