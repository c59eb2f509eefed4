#pragma once

// Outward rounding from double to float, for boxes that must contain what was measured in double.

#include <bit>
#include <cstdint>

namespace tandem::haptics {

/// The next float below f.
inline float below(float f) {
  if (f == 0.0f) return std::bit_cast<float>(0x80000001u);
  const auto bits = std::bit_cast<std::uint32_t>(f);
  return std::bit_cast<float>(bits + ((bits >> 31) * 2u - 1u));
}

/// The largest float that is not above x: std::nextafter() without an unpredictable branch.
inline float roundDown(double x) {
  const float f = static_cast<float>(x);
  const std::uint32_t above = static_cast<double>(f) > x ? 1u : 0u;
  if (f == 0.0f) return above != 0u ? std::bit_cast<float>(0x80000001u) : f;
  const auto bits = std::bit_cast<std::uint32_t>(f);
  return std::bit_cast<float>(bits + above * ((bits >> 31) * 2u - 1u));
}

/// The smallest float that is not below x.
inline float roundUp(double x) { return -roundDown(-x); }

}  // namespace tandem::haptics
