#pragma once

// DualSense protocol: its reports byte by byte. Pure: no device, no clock.
//
// Layouts follow SDL (src/joystick/hidapi/SDL_hidapi_ps5.c) and Linux (drivers/hid/hid-playstation.c). Input
// over USB is report 01 of 64 bytes; over Bluetooth it is report 31 of 78 bytes with a checksum once feature
// report 05 has been requested, and before that a short report 01 of 10 bytes (sticks, buttons, triggers).
// Output is report 02 of 48 bytes over USB and report 31 of 78 bytes over Bluetooth.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "assets/base/pose.h"

namespace tandem::haptics {

/// Bits of DualSenseState::buttons.
enum DualSenseButton : std::uint32_t {
  kPadSquare = 1u << 0,
  kPadCross = 1u << 1,
  kPadCircle = 1u << 2,
  kPadTriangle = 1u << 3,
  kPadL1 = 1u << 4,
  kPadR1 = 1u << 5,
  kPadL2 = 1u << 6,
  kPadR2 = 1u << 7,
  kPadCreate = 1u << 8,
  kPadOptions = 1u << 9,
  kPadL3 = 1u << 10,
  kPadR3 = 1u << 11,
};

struct DualSenseState {
  double leftX = 0.0, leftY = 0.0, rightX = 0.0,
         rightY = 0.0;                           // -1..1, right and back (towards the user) positive
  double leftTrigger = 0.0, rightTrigger = 0.0;  // 0..1
  std::uint32_t buttons = 0;
  std::array<std::int16_t, 3> gyro{};  // raw: about x (right), y (up), z (to the user)
  bool hasMotion = false;              // the short report has none
  bool bluetooth = false;
};

/// Decodes one input report from hidapi; false, with `state` unchanged, if its layout is unknown or its
/// checksum is wrong.
bool decodeDualSenseReport(std::span<const std::uint8_t> report, DualSenseState& state);

/// Raw gyro to rad/s: (raw - bias) * scale. Nominal: 2000 degrees a second at full range.
struct GyroCalibration {
  glm::dvec3 bias{0.0, 0.0, 0.0};
  glm::dvec3 scale{0.0010652644360316953, 0.0010652644360316953, 0.0010652644360316953};
  glm::dvec3 rate(const std::array<std::int16_t, 3>& raw) const {
    return (glm::dvec3(raw[0], raw[1], raw[2]) - bias) * scale;
  }
};

/// Calibration from feature report 05; nominal if the report is too short or implausible.
GyroCalibration decodeGyroCalibration(std::span<const std::uint8_t> report);

/// Output of the controller.
struct DualSenseOutput {
  std::uint8_t strong = 0, weak = 0;                     // rumble, 0..255
  std::uint8_t leftResistance = 0, rightResistance = 0;  // of a trigger over its whole travel, 0..255
  bool operator==(const DualSenseOutput&) const = default;
};

/// The output report; `sequence` (0..15) counts Bluetooth reports.
std::vector<std::uint8_t> encodeDualSense(const DualSenseOutput& output, bool bluetooth,
                                          std::uint8_t sequence);

/// Checksum of Bluetooth reports: CRC-32 (IEEE 802.3) over a direction byte (A2 out, A1 in) and the report.
std::uint32_t dualSenseChecksum(std::uint8_t direction, std::span<const std::uint8_t> bytes);

/// Cues for a force on a controller that cannot push: trigger resistance for its steady part, rumble for its
/// change. Levels are coarse, so a steady force sends nothing.
class GripCues {
 public:
  /// Takes the force for dt s; `full` N is the strongest cue. A non-finite force counts as zero.
  DualSenseOutput step(double force, double full, double dt);

 private:
  double settled_ = 0.0;  // N, the force of the last 50 ms
};

}  // namespace tandem::haptics
