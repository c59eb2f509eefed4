#include "haptics/link/wave_play_out.h"

#include <cmath>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

bool isFinite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

PlayedWave between(const LinkPacket& before, const LinkPacket& after, double time) {
  const double span = after.time - before.time, share = (time - before.time) / span;
  PlayedWave played;
  played.fresh = true;
  played.state = before;
  played.state.time = time;
  played.state.wave += share * (after.wave - before.wave);
  played.state.energy += share * (after.energy - before.energy);
  played.state.worldFromDrawn = interpolate(before.worldFromDrawn, after.worldFromDrawn, share);
  played.rate = (1.0 / span) * (after.wave - before.wave);
  return played;
}

/// A peer's fade grows, or has had time to begin anew from zero.
bool breaksFade(const LinkPacket& before, const LinkPacket& after) {
  return after.fade < before.fade && after.fade > WavePlayOut::kFastestFade * (after.time - before.time);
}

}  // namespace

bool isValid(const LinkPacket& p) {
  return std::isfinite(p.time) && isFinite(p.wave.along) && isFinite(p.wave.about) &&
         std::isfinite(p.energy) && p.energy >= 0.0 && p.fade >= 0.0 && p.fade <= 1.0 &&
         p.regime <= LinkRegime::apart && isValid(p.worldFromDrawn) && isFinite(p.twist.linear) &&
         isFinite(p.twist.angular);
}

void WavePlayOut::restart(std::uint32_t epoch) {
  epoch_ = before_ = epoch;
  first_ = count_ = 0;
  playedTo_ = kNothingPlayed;
}

void WavePlayOut::carryOn(std::uint32_t epoch) {
  before_ = epoch_;
  epoch_ = epoch;
}

void WavePlayOut::dropFirst() {
  ASSERT(count_ > 0 && first_ < kCapacity);
  first_ = (first_ + 1) % kCapacity;
  --count_;
}

bool WavePlayOut::receive(const LinkPacket& packet) {
  if ((packet.epoch != epoch_ && packet.epoch != before_) || !isValid(packet)) return false;
  std::size_t place = count_;
  while (place > 0 && at(place - 1).sequence > packet.sequence) --place;
  // The first packet is being played already.
  const bool late = place == 0 && count_ > 0 && at(0).time <= playedTo_;
  const bool known = place > 0 && at(place - 1).sequence == packet.sequence;
  // Time, energy and fade must grow with the sequence; a peer that violates this is ignored.
  const bool behind =
      place > 0 && (at(place - 1).time >= packet.time || at(place - 1).energy > packet.energy ||
                    breaksFade(at(place - 1), packet));
  const bool ahead = place < count_ && (at(place).time <= packet.time || at(place).energy < packet.energy ||
                                        breaksFade(packet, at(place)));
  contradicted_ = contradicted_ || (!late && !known && (behind || ahead));
  if (late || known || behind || ahead) return false;
  if (count_ == kCapacity) {
    if (place == 0) return false;
    dropFirst();
    --place;
  }
  for (std::size_t i = count_; i > place; --i) at(i) = at(i - 1);
  ASSERT(count_ < kCapacity && place <= count_);
  at(place) = packet;
  ++count_;
  if (packet.epoch == epoch_) before_ = epoch_;
  return true;
}

PlayedWave WavePlayOut::play(double time) {
  ASSERT(count_ <= kCapacity);
  playedTo_ = time;
  while (count_ >= 2 && at(1).time <= time) dropFirst();
  if (count_ >= 2 && at(0).time <= time) return between(at(0), at(1), time);
  PlayedWave last;
  if (count_ > 0 && at(0).time <= time) last.state = at(0);
  return last;
}

}  // namespace tandem::haptics
