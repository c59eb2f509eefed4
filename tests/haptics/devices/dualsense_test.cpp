#include "haptics/devices/dualsense.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "haptics/devices/device_list.h"
#include "tests/support/scripted_hid.h"

namespace tandem::haptics {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::ScriptedHid;

/// A USB report at rest: sticks in the middle, hat released.
Bytes usbReport() {
  Bytes report(64, 0);
  report[0] = 0x01;
  report[1] = report[2] = report[3] = report[4] = 0x80;
  report[8] = 0x08;
  return report;
}

/// The same over Bluetooth.
Bytes bluetoothReport() {
  const Bytes usb = usbReport();
  Bytes report(78, 0);
  report[0] = 0x31;
  std::copy(usb.begin() + 1, usb.end(), report.begin() + 2);
  const std::uint32_t crc = dualSenseChecksum(0xA1, std::span(report).first(74));
  for (int i = 0; i < 4; ++i)
    report[static_cast<std::size_t>(74 + i)] = static_cast<std::uint8_t>(crc >> (8 * i));
  return report;
}

TEST(DualSenseCodec, ReadsSticksTriggersButtonsAndGyro) {
  Bytes report = usbReport();
  report[1] = 0xFF, report[2] = 0x00;  // left stick: right and forwards
  report[6] = 0xFF;                    // right trigger pulled
  report[8] = 0x28, report[9] = 0x02;  // cross, R1
  report[16] = 0x34, report[17] = 0x12, report[18] = 0xFF, report[19] = 0xFF;
  DualSenseState state;
  ASSERT_TRUE(decodeDualSenseReport(report, state));
  EXPECT_EQ(state.leftX, 1.0);
  EXPECT_EQ(state.leftY, -1.0);
  EXPECT_EQ(state.rightX, 0.0);
  EXPECT_EQ(state.rightTrigger, 1.0);
  EXPECT_EQ(state.buttons, kPadCross | kPadR1);
  EXPECT_EQ(state.gyro[0], 0x1234);
  EXPECT_EQ(state.gyro[1], -1);
  EXPECT_FALSE(state.bluetooth);
}

TEST(DualSenseCodec, ReadsBluetoothReportsAndTheShortOne) {
  DualSenseState state;
  ASSERT_TRUE(decodeDualSenseReport(bluetoothReport(), state));
  EXPECT_TRUE(state.bluetooth);
  EXPECT_TRUE(state.hasMotion);
  Bytes damaged = bluetoothReport();
  damaged[20] ^= 1;
  EXPECT_FALSE(decodeDualSenseReport(damaged, state));
  ASSERT_TRUE(decodeDualSenseReport(Bytes{0x01, 0x80, 0x80, 0x80, 0xFF, 0x48, 0, 0, 0, 0xFF}, state));
  EXPECT_EQ(state.rightY, 1.0);
  EXPECT_EQ(state.buttons, kPadCircle);
  EXPECT_EQ(state.rightTrigger, 1.0);
  EXPECT_FALSE(state.hasMotion);
  EXPECT_FALSE(decodeDualSenseReport(Bytes{}, state));
  EXPECT_FALSE(decodeDualSenseReport(Bytes(63, 1), state));
}

TEST(DualSenseCodec, TheChecksumIsTheOneOfEthernet) {
  // "123456789" is CBF43926 in every catalogue of CRC-32; the first character goes as the direction byte.
  const Bytes rest{'2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(dualSenseChecksum('1', rest), 0xCBF43926u);
}

TEST(DualSenseCodec, WritesRumbleAndTriggersOverBothWays) {
  const DualSenseOutput output{.strong = 200, .weak = 100, .leftResistance = 0, .rightResistance = 110};
  const Bytes usb = encodeDualSense(output, false, 0);
  ASSERT_EQ(usb.size(), 48u);
  EXPECT_EQ((Bytes(usb.begin(), usb.begin() + 5)), (Bytes{0x02, 0x0F, 0x00, 100, 200}));
  EXPECT_EQ((Bytes(usb.begin() + 11, usb.begin() + 14)), (Bytes{0x01, 0, 110}));
  EXPECT_EQ((Bytes(usb.begin() + 22, usb.begin() + 25)), (Bytes{0x05, 0, 0}));

  const Bytes air = encodeDualSense(output, true, 3);
  ASSERT_EQ(air.size(), 78u);
  EXPECT_EQ((Bytes(air.begin(), air.begin() + 3)), (Bytes{0x31, 0x30, 0x10}));
  EXPECT_TRUE(std::equal(usb.begin() + 1, usb.end(), air.begin() + 3));
  const std::uint32_t crc = dualSenseChecksum(0xA2, std::span(air).first(74));
  EXPECT_EQ(air[74] | air[75] << 8 | air[76] << 16 | static_cast<std::uint32_t>(air[77]) << 24, crc);
}

TEST(DualSenseCodec, CalibratesTheGyroAndDistrustsNonsense) {
  Bytes report(41, 0);
  report[0] = 0x05;
  const auto put = [&report](std::size_t at, int value) {
    report[at] = static_cast<std::uint8_t>(value), report[at + 1] = static_cast<std::uint8_t>(value >> 8);
  };
  put(1, 10);
  for (const std::size_t axis : {0u, 1u, 2u}) put(7 + 4 * axis, 8850), put(9 + 4 * axis, -8850);
  put(19, 540), put(21, 540);
  const GyroCalibration read = decodeGyroCalibration(report);
  EXPECT_EQ(read.bias.x, 10.0);
  // 540 degrees a second at 8850 counts.
  EXPECT_NEAR(read.rate({0, 8850, 0}).y, 540.0 * std::numbers::pi / 180.0, 1e-9);
  put(19, 0), put(21, 0);
  EXPECT_EQ(decodeGyroCalibration(report).scale, GyroCalibration{}.scale);
  EXPECT_EQ(decodeGyroCalibration(Bytes(5, 5)).scale, GyroCalibration{}.scale);
}

TEST(DualSenseCodec, AnyBytesAreSafe) {
  std::mt19937 random(11);
  DualSenseState state;
  for (int round = 0; round < 5000; ++round) {
    Bytes bytes(random() % 90);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (!bytes.empty()) bytes[0] = round % 2 == 0 ? 0x01 : 0x31;
    if (decodeDualSenseReport(bytes, state)) {
      EXPECT_LE(std::abs(state.leftX), 1.0);
    }
    decodeGyroCalibration(bytes);
  }
}

TEST(GripCues, AContactRumblesOnceAndASteadyForceOnlyResists) {
  GripCues cues;
  EXPECT_EQ(cues.step(0.0, 3.3, 1e-3), DualSenseOutput{});
  const DualSenseOutput hit = cues.step(3.3, 3.3, 1e-3);
  EXPECT_EQ(hit.rightResistance, 255);
  EXPECT_GT(hit.weak, 200);
  DualSenseOutput rest;
  for (int tick = 0; tick < 500; ++tick) rest = cues.step(3.3, 3.3, 1e-3);
  EXPECT_EQ(rest, (DualSenseOutput{0, 0, 255, 255}));
  EXPECT_EQ(cues.step(std::nan(""), 3.3, 1e-3), DualSenseOutput{});
}

// --- the driver on a scripted bus

const HidInfo kPad{"/dev/hidraw4", 0x054c, 0x0ce6, "Sony", "DualSense", "", 1, 5};

template <typename Condition>
void until(Condition condition) {
  while (!condition()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

TEST(DualSense, SticksMoveTheHandAndButtonsGrasp) {
  ScriptedHid bus(kPad);
  DualSense device(bus);
  ASSERT_TRUE(device.open().ok());
  Bytes report = usbReport();
  report[1] = 0xFF;  // left stick to the right
  report[8] = 0x28;  // cross
  bus.send(report);
  double now = 0.0;
  until([&] { return device.poll(now).buttons == 1; });
  for (int tick = 0; tick < 300; ++tick) device.poll(now += 1e-3), device.apply({});
  const glm::dvec3 p = device.poll(now).worldFromDevice.position;
  EXPECT_GT(p.x, 0.02);
  EXPECT_NEAR(p.y, 0.0, 1e-4);
  EXPECT_NEAR(p.z, 0.0, 1e-4);
}

TEST(DualSense, AForceTightensTheTriggersAndSilenceLetsThemGo) {
  ScriptedHid bus(kPad);
  DualSense device(bus);
  ASSERT_TRUE(device.open().ok());
  bus.send(usbReport());
  double now = 0.0;
  const auto wrote = [&](const DualSenseOutput& output) {
    for (const Bytes& report : bus.written())
      if (report == encodeDualSense(output, false, 0)) return true;
    return false;
  };
  until([&] {
    device.poll(now += 1e-3);
    device.apply({{3.3, 0.0, 0.0}, {}});
    return wrote({0, 0, 255, 255});  // the rumble of the contact has died away
  });
  until([&] { return wrote({}); });  // nobody calls apply() any more
  const std::vector<DeviceReport> reports = listDevices(bus);
  EXPECT_EQ(std::ranges::count(reports, "dualsense", &DeviceReport::driver), 1);
  bus.plug(false);
  until([&] { return !device.poll(now).valid; });
}

}  // namespace
}  // namespace tandem::haptics
