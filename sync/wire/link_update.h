#pragma once

// What the two ends of a coordination link send each other.

#include <array>
#include <cstdint>

#include "assets/base/ids.h"
#include "assets/base/pose.h"

namespace tandem::sync {

/// What both ends of a coordination link use, as its owner decides: multiples of the quanta below.
struct LinkAgreement {
  double impedance = 27.0, softImpedance = 14.0;  // N·s/m, of the regimes stiff and soft
  double packetPeriod = 4e-3;                     // s, between packets of either end
  friend bool operator==(const LinkAgreement&, const LinkAgreement&) = default;
};
inline constexpr double kImpedanceQuantum = 0.125;       // N·s/m
inline constexpr double kPacketPeriodQuantum = 0.25e-3;  // s

/// One end of a coordination link to the other, by way of the server. Integrals and clocks are sent by their
/// low bits; LinkReceiver (link_stream.h) completes them.
struct LinkUpdate {
  SiteId peer = kNoSite;  // to the server: the addressee; from the server: the sender
  PartId part = kNoPart;
  std::uint32_t epoch = 0;  // of the link, chosen by the owner; larger than any earlier one of this link
  std::uint16_t sequence = 0;
  std::uint32_t time = 0;               // low 24 bits of session time in us
  std::array<std::uint32_t, 6> wave{};  // steps of kWaveQuantum, 24 bits each
  std::uint32_t energy = 0;             // steps of kEnergyQuantum
  std::uint8_t fade = 0;                // 255ths
  bool on = false, asks = false;
  std::uint8_t regime = 0;  // 0 stiff, 1 soft, 2 apart
  bool posed = false;       // whether the fields that follow are present
  Pose worldFromDrawn;
  Twist twist;
  LinkAgreement terms;
};
inline constexpr double kWaveQuantum = 1e-5;    // sqrt(W) s
inline constexpr double kEnergyQuantum = 1e-7;  // J

}  // namespace tandem::sync
