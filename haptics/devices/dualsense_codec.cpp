#include "haptics/devices/dualsense_codec.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr std::size_t kUsbReport = 64, kBluetoothReport = 78, kShortReport = 10;
constexpr std::size_t kUsbOutput = 48, kState = 47;
constexpr double kForceSettling = 0.05;  // s

double stick(std::uint8_t value) {
  return std::clamp((static_cast<double>(value) - 128.0) / 127.0, -1.0, 1.0);
}

std::int16_t word(std::span<const std::uint8_t> bytes, std::size_t at) {
  ASSERT(at + 1 < bytes.size());
  return static_cast<std::int16_t>(bytes[at] | bytes[at + 1] << 8);
}

/// Sticks are bytes 0..3 of every layout; square to triangle are the upper half of the first button byte.
void readButtons(std::span<const std::uint8_t> two, DualSenseState& state) {
  ASSERT(two.size() >= 2);
  state.buttons = static_cast<std::uint32_t>(two[0] >> 4) | static_cast<std::uint32_t>(two[1]) << 4;
}

void readSticks(std::span<const std::uint8_t> data, DualSenseState& state) {
  ASSERT(data.size() >= 4);
  state.leftX = stick(data[0]), state.leftY = stick(data[1]);
  state.rightX = stick(data[2]), state.rightY = stick(data[3]);
}

void readFull(std::span<const std::uint8_t> data, DualSenseState& state) {
  ASSERT(data.size() >= 21);
  readSticks(data, state);
  state.leftTrigger = data[4] / 255.0, state.rightTrigger = data[5] / 255.0;
  readButtons(data.subspan(7), state);
  state.gyro = {word(data, 15), word(data, 17), word(data, 19)};
  state.hasMotion = true;
}

/// A trigger effect of constant resistance over the whole travel, or none.
void putTrigger(std::span<std::uint8_t> effect, std::uint8_t resistance) {
  ASSERT(effect.size() == 11);
  effect[0] = resistance > 0 ? 0x01 : 0x05;
  effect[2] = resistance;
}

std::uint32_t littleEndian(std::span<const std::uint8_t> four) {
  ASSERT(four.size() == 4);
  return four[0] | static_cast<std::uint32_t>(four[1]) << 8 | static_cast<std::uint32_t>(four[2]) << 16 |
         static_cast<std::uint32_t>(four[3]) << 24;
}

std::uint8_t coarse(double share, int levels) {
  if (!(share > 0.0)) return 0;
  return static_cast<std::uint8_t>(std::lround(std::min(share, 1.0) * levels) * 255 / levels);
}

}  // namespace

std::uint32_t dualSenseChecksum(std::uint8_t direction, std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFFFFFF;
  const auto add = [&crc](std::uint8_t byte) {
    crc ^= byte;
    for (int i = 0; i < 8; ++i) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xEDB88320u : 0u);
  };
  add(direction);
  for (const std::uint8_t byte : bytes) add(byte);
  return ~crc;
}

bool decodeDualSenseReport(std::span<const std::uint8_t> report, DualSenseState& state) {
  if (report.empty()) return false;
  DualSenseState next;
  if (report[0] == 0x01 && report.size() == kUsbReport) {
    readFull(report.subspan(1), next);
  } else if (report[0] == 0x31 && report.size() == kBluetoothReport) {
    const auto body = report.first(kBluetoothReport - 4);
    if (dualSenseChecksum(0xA1, body) != littleEndian(report.last(4))) return false;
    readFull(report.subspan(2), next);
    next.bluetooth = true;
  } else if (report[0] == 0x01 && report.size() == kShortReport) {
    readSticks(report.subspan(1), next);
    readButtons(report.subspan(5), next);
    next.leftTrigger = report[8] / 255.0, next.rightTrigger = report[9] / 255.0;
    next.bluetooth = true;
  } else {
    return false;
  }
  state = next;
  return true;
}

GyroCalibration decodeGyroCalibration(std::span<const std::uint8_t> report) {
  const GyroCalibration nominal;
  if (report.size() < 23 || report[0] != 0x05) return nominal;
  GyroCalibration read;
  const double speed = word(report, 19) + word(report, 21);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    read.bias[i] = word(report, 1 + 2 * axis);
    const double plus = word(report, 7 + 4 * axis), minus = word(report, 9 + 4 * axis);
    const double range = std::abs(plus - read.bias[i]) + std::abs(minus - read.bias[i]);
    read.scale[i] = speed / range * std::numbers::pi / 180.0;
    if (!(read.scale[i] > 0.5 * nominal.scale[i] && read.scale[i] < 2.0 * nominal.scale[i])) return nominal;
  }
  return read;
}

std::vector<std::uint8_t> encodeDualSense(const DualSenseOutput& output, bool bluetooth,
                                          std::uint8_t sequence) {
  std::vector<std::uint8_t> report(bluetooth ? kBluetoothReport : kUsbOutput, 0);
  const auto state = std::span(report).subspan(bluetooth ? 3 : 1, kState);
  state[0] = 0x01 | 0x02 | 0x04 | 0x08;  // rumble, not sound; both triggers
  state[2] = output.weak;
  state[3] = output.strong;
  putTrigger(state.subspan(10, 11), output.rightResistance);
  putTrigger(state.subspan(21, 11), output.leftResistance);
  if (!bluetooth) {
    report[0] = 0x02;
    return report;
  }
  report[0] = 0x31;
  report[1] = static_cast<std::uint8_t>((sequence & 15) << 4);
  report[2] = 0x10;
  const std::uint32_t crc = dualSenseChecksum(0xA2, std::span(report).first(kBluetoothReport - 4));
  for (std::size_t i = 0; i < 4; ++i)
    report[kBluetoothReport - 4 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
  return report;
}

DualSenseOutput GripCues::step(double force, double full, double dt) {
  if (!std::isfinite(force) || !(full > 0.0)) force = 0.0;
  force = std::min(std::abs(force), full);
  if (dt > 0.0) settled_ += (1.0 - std::exp(-dt / kForceSettling)) * (force - settled_);
  const double change = std::max(0.0, force - settled_) / full;
  DualSenseOutput output;
  output.rightResistance = output.leftResistance = coarse(force / full, 31);
  output.weak = coarse(change, 15);
  output.strong = coarse(0.5 * change, 15);
  return output;
}

}  // namespace tandem::haptics
