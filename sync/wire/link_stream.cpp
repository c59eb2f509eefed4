#include "sync/wire/link_stream.h"

#include <algorithm>
#include <cmath>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

constexpr double kWhole24 = 16777216.0;
constexpr std::uint32_t kLow24 = (1u << 24) - 1;
constexpr Micros kMaxAhead = kSecond / 2;  // synchronised clocks differ by less
constexpr std::uint32_t kPoseEvery = 8;    // datagrams; the pose bounds the error after losses

/// The low 32 bits of a whole number of steps, in two's complement.
std::uint32_t lowBits(double steps) {
  constexpr double kWhole = 4294967296.0;
  return static_cast<std::uint32_t>(steps - kWhole * std::floor(steps / kWhole));
}

/// The whole number with these low bits that is nearest to `known`.
double nearest(double known, std::uint32_t low, double whole) {
  const double base = known - static_cast<double>(low);
  return static_cast<double>(low) + whole * std::round(base / whole);
}

Pose advanced(const Pose& pose, const Twist& twist, double seconds) {
  return {pose.position + seconds * twist.linear,
          glm::normalize(fromRotationVector(seconds * twist.angular) * pose.orientation)};
}

}  // namespace

std::optional<Micros> sessionTimeOf(const LinkUpdate& update, Micros now) {
  const auto time = static_cast<Micros>(nearest(static_cast<double>(now), update.time, kWhole24));
  if (time > now + kMaxAhead) return std::nullopt;
  return time;
}

LinkUpdate toWire(const LinkState& state, SiteId peer, PartId part) {
  LinkUpdate update;
  update.peer = peer;
  update.part = part;
  update.epoch = state.epoch;
  update.sequence = static_cast<std::uint16_t>(state.sequence);
  update.time = static_cast<std::uint32_t>(state.time) & kLow24;
  for (std::size_t i = 0; i < 6; ++i)
    update.wave[i] = lowBits(std::round(state.wave[i] / kWaveQuantum)) & kLow24;
  update.energy = lowBits(std::floor(std::max(0.0, state.energy) / kEnergyQuantum));
  update.fade = static_cast<std::uint8_t>(255.0 * std::clamp(state.fade, 0.0, 1.0));
  update.on = state.on;
  update.asks = state.asks;
  update.regime = state.regime;
  update.posed = state.sequence <= kPoseEvery || state.sequence % kPoseEvery == 1 || !state.on;
  update.worldFromDrawn = state.worldFromDrawn;
  update.twist = state.twist;
  return update;
}

std::optional<LinkState> LinkReceiver::receive(const LinkUpdate& update, Micros now) {
  const std::optional<Micros> time = sessionTimeOf(update, now);
  return time ? receiveAt(update, *time) : std::nullopt;
}

std::optional<LinkState> LinkReceiver::receiveAt(const LinkUpdate& update, Micros time) {
  if (!begun_ || update.epoch > newest_.epoch) {
    begun_ = true;
    posed_ = false;
    newest_ = LinkState{};
    newest_.epoch = update.epoch;
    newest_.sequence = update.sequence;
  } else if (update.epoch < newest_.epoch) {
    return std::nullopt;
  }
  constexpr double kWhole32 = 4294967296.0;
  LinkState state;
  state.epoch = update.epoch;
  const auto ahead =
      static_cast<std::int16_t>(update.sequence - static_cast<std::uint16_t>(newest_.sequence));
  state.sequence = newest_.sequence + static_cast<std::uint32_t>(std::int32_t{ahead});
  state.time = time;
  for (std::size_t i = 0; i < 6; ++i)
    state.wave[i] = kWaveQuantum * nearest(newest_.wave[i] / kWaveQuantum, update.wave[i], kWhole24);
  state.energy =
      kEnergyQuantum * std::max(0.0, nearest(newest_.energy / kEnergyQuantum, update.energy, kWhole32));
  state.fade = update.fade / 255.0;
  state.on = update.on;
  state.asks = update.asks;
  state.regime = update.regime;
  if (update.posed) {
    state.worldFromDrawn = update.worldFromDrawn;
    state.twist = update.twist;
    if (!posed_ || state.time > withPose_.time) withPose_ = state;
    posed_ = true;
  } else if (posed_) {
    state.twist = withPose_.twist;
    state.worldFromDrawn =
        advanced(withPose_.worldFromDrawn, withPose_.twist, toSeconds(state.time - withPose_.time));
  }
  ASSERT(state.epoch == newest_.epoch);
  if (ahead >= 0) newest_ = state;
  if (!posed_) return std::nullopt;
  return state;
}

}  // namespace tandem::sync
