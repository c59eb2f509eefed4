#pragma once

// Force feedback over HID by the USB PID class: the reports of a device and their bytes. Report ids and field
// places come from the device's descriptor, never from a table. Pure.
//
// Source: USB Device Class Definition for Physical Interface Devices 1.0; usages of page 0F from the HID
// Usage Tables 1.4. No angles are sent where the device takes "axes enable" bits.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "haptics/devices/hid_descriptor.h"

namespace tandem::haptics {

/// A report and the fields of it, by usage.
struct PidReport {
  HidKind kind = HidKind::kOutput;
  std::uint8_t id = 0;
  std::size_t bytes = 0;  // as sent, the id byte included; 0: the device has no such report
  std::vector<HidField> fields;

  bool present() const { return bytes > 0; }
  /// The variable field of a usage, or the array field that offers it as a choice; null when there is none.
  const HidField* find(HidUsage usage) const;
};

/// Capabilities of a device from its descriptor.
struct PidLayout {
  HidLayout hid;
  std::vector<HidField> axes;     // of the input report: X, Y (and steering as the only one), at most two
  std::vector<HidField> buttons;  // at most 32
  PidReport control, gain, pool, create, load, free, set, constant, condition, operation;

  /// Number of axes with a force of their own: those that the input has and Set Effect can address.
  int forceAxes() const;
};

/// Finds the reports of a force-feedback device. Refused, with the reason, when the descriptor cannot be
/// parsed or one of the reports that a constant force needs is missing.
Result<PidLayout> findPid(std::span<const std::uint8_t> descriptor);

/// One reading. Axes are -1..1 over the logical range.
struct PidState {
  std::array<double, 2> axes{};
  std::uint32_t buttons = 0;
};

/// Decodes an input report from hidapi; false if it holds no axes or buttons of this device.
bool decodePidInput(const PidLayout& layout, std::span<const std::uint8_t> report, PidState& state);

enum class PidControl : std::uint16_t { kEnable = 0x97, kDisable = 0x98, kStopAll = 0x99, kReset = 0x9A };
enum class PidEffect : std::uint16_t { kConstant = 0x26, kSpring = 0x40, kDamper = 0x41 };
enum class PidOperation : std::uint16_t { kStart = 0x79, kStop = 0x7B };

using PidBytes = std::vector<std::uint8_t>;

PidBytes encodeControl(const PidLayout& layout, PidControl what);
/// Sets the gain to `share`, 0..1 of full force.
PidBytes encodeGain(const PidLayout& layout, double share);
/// The feature report that requests an effect; empty if the device does not offer its type.
PidBytes encodeCreate(const PidLayout& layout, PidEffect type);

/// The answer to a request for an effect.
struct PidBlock {
  enum Status { kLoaded, kFull, kError, kUnknown } status = kUnknown;
  std::uint8_t index = 0;
};
PidBlock decodeBlockLoad(const PidLayout& layout, std::span<const std::uint8_t> report);

/// An effect without end on one axis (0 or 1), at full gain, with no trigger.
PidBytes encodeSetEffect(const PidLayout& layout, std::uint8_t block, PidEffect type, int axis);
/// The update at loop rate: `share` -1..1 of the largest magnitude.
PidBytes encodeConstant(const PidLayout& layout, std::uint8_t block, double share);

/// A spring or damper that the device runs by itself, on one axis. All -1..1 (coefficients, centre) or 0..1.
struct PidCondition {
  double centre = 0.0, coefficient = 0.0, saturation = 1.0, deadBand = 0.0;
};
PidBytes encodeCondition(const PidLayout& layout, std::uint8_t block, int axis,
                         const PidCondition& condition);
PidBytes encodeOperation(const PidLayout& layout, std::uint8_t block, PidOperation what);
PidBytes encodeFree(const PidLayout& layout, std::uint8_t block);

}  // namespace tandem::haptics
