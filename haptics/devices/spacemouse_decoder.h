#pragma once

// SpaceMouse protocol: its reports byte by byte, and their meaning as a motion. Pure: no device, no clock.
//
// Report layouts follow the published tables of spacenavd (github.com/FreeSpacenav/spacenavd, src/dev.c) and
// PySpaceMouse (github.com/JakubAndrysek/PySpaceMouse, devices.toml). The length alone distinguishes the two
// formats:
//   A  01 X Y Z (7 bytes), 02 RX RY RZ (7 bytes)      B  01 X Y Z RX RY RZ (13 bytes)
//   buttons  03 bits (1 to 4 bytes, least significant first)      battery  17 percent
// Axes are 16-bit little-endian, about +-350. Raw axes: x right, y towards the user, z down.

#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <span>

#include "assets/base/pose.h"

namespace tandem::haptics {

struct SpaceMouseModel {
  std::uint16_t vendor, product;
  const char* name;
};

/// Every model with support.
std::span<const SpaceMouseModel> spaceMouseModels();

/// The model's name, or null for anything but a supported six-axis device.
const char* spaceMouseName(std::uint16_t vendor, std::uint16_t product);

/// The latest known deflection and buttons.
struct SpaceMouseState {
  std::array<double, 6> axes{};  // x y z rx ry rz, raw axes, -1..1
  std::uint32_t buttons = 0;     // bit i = button i
  int battery = -1;              // percent; -1: not reported
};

/// Decodes one input report, its id first; false, with `state` unchanged, for any other layout.
bool decodeSpaceMouseReport(std::span<const std::uint8_t> report, SpaceMouseState& state);

/// Response curve from deflection to speed.
struct VelocityCurve {
  double deadZone = 0.06;  // fraction of the full deflection, on each axis
  double linearShare =
      0.15;  // linear share of the response; the rest is cubic: fine near the middle, fast at the end
  double maxSpeed = 0.15;    // m/s at full deflection
  double maxTurnRate = 1.5;  // rad/s at full deflection
};

/// The twist for a deflection, in axes of the view (x right, y up, z towards the user), turned by
/// worldFromView.
Twist twistFromDeflection(const std::array<double, 6>& axes, const VelocityCurve& curve,
                          const glm::dquat& worldFromView);

}  // namespace tandem::haptics
