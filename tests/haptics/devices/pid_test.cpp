#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <random>

#include "haptics/devices/device_list.h"
#include "haptics/devices/pacer.h"
#include "haptics/devices/pid_codec.h"
#include "haptics/devices/pid_device.h"
#include "tests/support/pid_descriptor.h"
#include "tests/support/scripted_hid.h"

namespace tandem::haptics {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::PidDescriptor;
using testing::ScriptedHid;

PidLayout layoutOf(std::uint8_t shift = 0) {
  Result<PidLayout> layout = findPid(PidDescriptor(shift).bytes());
  if (!layout) ADD_FAILURE() << layout.error().message;
  return layout ? *layout : PidLayout{};
}

// --- the descriptor

TEST(HidDescriptor, FindsFieldsWithTheirPlaceRangeAndUsage) {
  // A boot mouse: three buttons, five bits of padding, X and Y of eight bits (HID 1.11, appendix E.10).
  const Bytes mouse{0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x09, 0x01, 0xA1, 0x00, 0x05, 0x09, 0x19,
                    0x01, 0x29, 0x03, 0x15, 0x00, 0x25, 0x01, 0x95, 0x03, 0x75, 0x01, 0x81, 0x02,
                    0x95, 0x01, 0x75, 0x05, 0x81, 0x01, 0x05, 0x01, 0x09, 0x30, 0x09, 0x31, 0x15,
                    0x81, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x02, 0x81, 0x06, 0xC0, 0xC0};
  const auto layout = parseHidDescriptor(mouse);
  ASSERT_TRUE(layout.ok()) << layout.error().message;
  EXPECT_FALSE(layout->numbered);
  ASSERT_EQ(layout->fields.size(), 5u);
  EXPECT_EQ(layout->fields[1].usages.front(), hidUsage(9, 2));
  EXPECT_EQ(layout->fields[1].bit, 1u);
  const HidField& y = layout->fields[4];
  EXPECT_EQ(y.usages.front(), hidUsage(1, 0x31));
  EXPECT_EQ(y.bit, 16u);
  EXPECT_EQ(y.low, -127);
  EXPECT_EQ(y.high, 127);
  EXPECT_TRUE(y.isInside(hidUsage(1, 2)));
  EXPECT_EQ(layout->reportBytes(HidKind::kInput, 0), 4u);
  EXPECT_EQ(readHidField(y, Bytes{0, 0, 0x80}), -128);
  EXPECT_EQ(readHidField(y, Bytes{0, 0}), 0) << "a short report has no such field";
}

TEST(HidDescriptor, WritesValuesClampedIntoTheirBitsAlone) {
  HidField field;
  field.bit = 3, field.bits = 10, field.low = -200, field.high = 200;
  Bytes data(3, 0xFF);
  writeHidField(field, data, -5);
  EXPECT_EQ(readHidField(field, data), -5);
  EXPECT_EQ(data[0] & 7, 7);
  EXPECT_EQ(data[1] >> 5, 7);
  EXPECT_EQ(data[2], 0xFF);
  writeHidField(field, data, 5000);
  EXPECT_EQ(readHidField(field, data), 200);
}

TEST(HidDescriptor, RefusesWhatDoesNotHoldTogether) {
  const auto refused = [](const Bytes& bytes) { return !parseHidDescriptor(bytes).ok(); };
  EXPECT_TRUE(refused({0x05}));                                            // cut off
  EXPECT_TRUE(refused({0xA1, 0x01}));                                      // not closed
  EXPECT_TRUE(refused({0xC0}));                                            // not opened
  EXPECT_TRUE(refused({0xB4}));                                            // pop without push
  EXPECT_TRUE(refused({0x85, 0x00}));                                      // report id 0
  EXPECT_TRUE(refused({0x19, 0x05, 0x29, 0x01}));                          // range backwards
  EXPECT_TRUE(refused({0x09, 0x01, 0x75, 0x40, 0x95, 0x01, 0x81, 0x02}));  // 64 bits
  EXPECT_TRUE(refused({0x09, 0x01, 0x75, 0x20, 0x97, 0xFF, 0xFF, 0xFF, 0xFF, 0x81, 0x02}));
  EXPECT_FALSE(refused({}));
  EXPECT_FALSE(refused({0xFE, 0x02, 0x00, 0xAA, 0xBB}));  // a long item is stepped over
  EXPECT_TRUE(refused({0xFE, 0x03, 0x00, 0xAA, 0xBB}));
}

TEST(HidDescriptor, AnyBytesAreSafe) {
  std::mt19937 random(5);
  const Bytes good = PidDescriptor().bytes();
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = good;
    for (int i = 0; i < 4; ++i) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    bytes.resize(random() % (bytes.size() + 1));
    const auto layout = findPid(bytes);
    if (!layout) continue;
    PidState state;
    decodePidInput(*layout, good, state);
    EXPECT_LE(encodeConstant(*layout, 1, 0.5).size(), 4097u);
  }
}

// --- the PID reports, byte by byte as OpenFFBoard's structures have them

TEST(PidCodec, EncodesTheSequenceThatStartsAConstantForce) {
  const PidLayout layout = layoutOf();
  EXPECT_EQ(layout.forceAxes(), 2);
  EXPECT_EQ(encodeControl(layout, PidControl::kReset), (Bytes{0x0C, 4}));
  EXPECT_EQ(encodeControl(layout, PidControl::kEnable), (Bytes{0x0C, 1}));
  EXPECT_EQ(encodeGain(layout, 1.0), (Bytes{0x0D, 0xFF}));
  EXPECT_EQ(encodeCreate(layout, PidEffect::kConstant), (Bytes{0x11, 1, 0, 0}));
  EXPECT_EQ(encodeCreate(layout, PidEffect::kDamper), (Bytes{0x11, 9, 0, 0}));
  EXPECT_EQ(encodeSetEffect(layout, 7, PidEffect::kConstant, 0),
            (Bytes{0x01, 7, 1, 0xFF, 0x7F, 0, 0, 0, 0, 0, 0, 0xFF, 0, 0x01, 0, 0, 0, 0}));
  EXPECT_EQ(encodeSetEffect(layout, 7, PidEffect::kConstant, 1)[13], 0x02);
  EXPECT_EQ(encodeOperation(layout, 7, PidOperation::kStart), (Bytes{0x0A, 7, 1, 1}));
  EXPECT_EQ(encodeOperation(layout, 7, PidOperation::kStop), (Bytes{0x0A, 7, 3, 0}));
  EXPECT_EQ(encodeFree(layout, 7), (Bytes{0x0B, 7}));
}

TEST(PidCodec, EncodesAForceAsItsShareOfTheRange) {
  const PidLayout layout = layoutOf();
  EXPECT_EQ(encodeConstant(layout, 7, -5000.0 / 32767.0), (Bytes{0x05, 7, 0x78, 0xEC}));
  EXPECT_EQ(encodeConstant(layout, 7, 1.0), (Bytes{0x05, 7, 0xFF, 0x7F}));
  EXPECT_EQ(encodeConstant(layout, 7, -3.0), (Bytes{0x05, 7, 0x01, 0x80}));
  EXPECT_EQ(encodeConstant(layout, 7, std::nan("")), (Bytes{0x05, 7, 0, 0}));
}

TEST(PidCodec, EncodesADamperThatTheDeviceRuns) {
  EXPECT_EQ(encodeCondition(layoutOf(), 9, 1, {.coefficient = 0.5}),
            (Bytes{0x03, 9, 1, 0, 0, 0x00, 0x40, 0x00, 0x40, 0xFF, 0x7F, 0xFF, 0x7F, 0, 0}));
}

TEST(PidCodec, TakesReportIdsFromTheDescriptor) {
  const PidLayout layout = layoutOf(0x20);
  EXPECT_EQ(encodeConstant(layout, 7, 1.0), (Bytes{0x25, 7, 0xFF, 0x7F}));
  EXPECT_EQ(encodeControl(layout, PidControl::kReset), (Bytes{0x2C, 4}));
  EXPECT_EQ(encodeCreate(layout, PidEffect::kConstant)[0], 0x31);
  EXPECT_EQ(decodeBlockLoad(layout, Bytes{0x32, 7, 1, 0, 0}).status, PidBlock::kLoaded);
  EXPECT_EQ(decodeBlockLoad(layout, Bytes{0x12, 7, 1, 0, 0}).status, PidBlock::kUnknown);
}

TEST(PidCodec, DecodesTheAnswerToARequest) {
  const PidLayout layout = layoutOf();
  const PidBlock loaded = decodeBlockLoad(layout, Bytes{0x12, 7, 1, 0x00, 0x10});
  EXPECT_EQ(loaded.status, PidBlock::kLoaded);
  EXPECT_EQ(loaded.index, 7);
  EXPECT_EQ(decodeBlockLoad(layout, Bytes{0x12, 0, 2, 0, 0}).status, PidBlock::kFull);
  EXPECT_EQ(decodeBlockLoad(layout, Bytes{0x12, 0, 3, 0, 0}).status, PidBlock::kError);
  EXPECT_EQ(decodeBlockLoad(layout, Bytes{0x12, 0, 0, 0, 0}).status, PidBlock::kUnknown);
  EXPECT_EQ(decodeBlockLoad(layout, Bytes{0x12}).status, PidBlock::kUnknown);
}

TEST(PidCodec, DecodesAxesAndButtons) {
  const PidLayout layout = layoutOf();
  PidState state;
  ASSERT_TRUE(decodePidInput(layout, Bytes{0x01, 0x05, 0x80, 0xFF, 0x7F, 0x01, 0xC0}, state));
  EXPECT_EQ(state.buttons, 0x8005u);
  EXPECT_DOUBLE_EQ(state.axes[0], 1.0);
  EXPECT_NEAR(state.axes[1], -0.5, 1e-4);
  EXPECT_FALSE(decodePidInput(layout, Bytes{0x02, 1, 2, 3, 4, 5, 6}, state));
  EXPECT_FALSE(decodePidInput(layout, Bytes{}, state));
}

TEST(PidCodec, RefusesAJoystickWithoutForces) {
  const Bytes plain{0x05, 0x01, 0x09, 0x04, 0xA1, 0x01, 0x09, 0x30, 0x09, 0x31, 0x15,
                    0x81, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x02, 0x81, 0x02, 0xC0};
  const auto layout = findPid(plain);
  ASSERT_FALSE(layout.ok());
  EXPECT_NE(layout.error().message.find("effects cannot be created"), std::string::npos);
}

// --- when forces are sent

TEST(Pacer, SendsOnChangeNotTooOftenAndZeroAtOnce) {
  Pacer<int> pacer(0.004, 0.05);
  EXPECT_FALSE(pacer.next(0.0, 0, 0.0)) << "zero is what it does anyway";
  EXPECT_EQ(pacer.next(0.001, 5, 0.001), 5);
  EXPECT_FALSE(pacer.next(0.002, 5, 0.002));
  EXPECT_FALSE(pacer.next(0.002, 6, 0.002)) << "too soon";
  EXPECT_EQ(pacer.next(0.0051, 6, 0.005), 6);
  EXPECT_EQ(pacer.next(0.0052, 0, 0.0052), 0) << "letting go does not wait";
}

TEST(Pacer, GoesToZeroWhenNobodySpeaks) {
  Pacer<int> pacer(0.001, 0.05);
  EXPECT_EQ(pacer.next(1.0, 9, 1.0), 9);
  EXPECT_FALSE(pacer.next(1.049, 9, 1.0));
  EXPECT_EQ(pacer.next(1.051, 9, 1.0), 0);
  EXPECT_FALSE(pacer.next(1.2, 9, 1.0));
  EXPECT_EQ(pacer.next(1.3, 9, 1.3), 9);
}

// --- the driver on a scripted bus

const HidInfo kJoystick{"/dev/hidraw9", 0x1209, 0xFFB0, "", "FFB joystick", "", 1, 4};

/// A joystick that grants effects one after another from block 7 on.
class PidDriver : public ::testing::Test {
 protected:
  PidDriver() : bus_(kJoystick) {
    bus_.describe(PidDescriptor().bytes());
    bus_.answer([this](std::uint8_t id) {
      if (id != 0x12) return Bytes{};
      // Busy at first: the driver must ask again.
      return ++asked_ % 2 == 1 ? Bytes{0x12, 0, 0, 0, 0}
                               : Bytes{0x12, static_cast<std::uint8_t>(6 + asked_ / 2), 1, 0, 0};
    });
  }
  template <typename Condition>
  static void until(Condition condition) {
    while (!condition()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  /// Applies a force over and over until the device was sent these bytes.
  void applyUntilTold(PidDevice& device, const glm::dvec3& force, const Bytes& bytes) {
    until([&] {
      device.apply({force, {}});
      for (const Bytes& report : bus_.written())
        if (report == bytes) return true;
      return false;
    });
  }

  ScriptedHid bus_;
  std::atomic<int> asked_{0};
};

TEST_F(PidDriver, StartsOneEffectAnAxisAndLeavesTheDeviceWithoutForce) {
  PidDevice device(bus_, Pose{{1.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}});
  ASSERT_TRUE(device.open().ok());
  EXPECT_EQ(bus_.features(), (std::vector<Bytes>{{0x11, 1, 0, 0}, {0x11, 1, 0, 0}}));
  const auto start = bus_.written();
  ASSERT_EQ(start.size(), 9u);
  EXPECT_EQ(start[0], (Bytes{0x0C, 4}));
  EXPECT_EQ(start[1], (Bytes{0x0C, 1}));
  EXPECT_EQ(start[5], (Bytes{0x0A, 7, 1, 1}));
  EXPECT_EQ(start[8], (Bytes{0x0A, 8, 1, 1}));

  bus_.send({0x01, 0x01, 0, 0xFF, 0x7F, 0, 0});
  until([&] { return device.poll(0.0).buttons == 1; });
  const DeviceSample sample = device.poll(0.001);
  EXPECT_TRUE(sample.valid);
  EXPECT_NEAR(sample.worldFromDevice.position.x, 1.05, 1e-9);

  applyUntilTold(device, {-1.5, 0.0, 0.0}, {0x05, 7, 0x00, 0xC0});
  applyUntilTold(device, {0.0, 0.0, 30.0}, {0x05, 8, 0xFF, 0x7F});
  device.close();
  const auto end = bus_.written();
  ASSERT_FALSE(end.empty());
  EXPECT_EQ(end.back(), (Bytes{0x0C, 2}));
  EXPECT_NE(std::ranges::find(end, Bytes{0x05, 8, 0, 0}), end.end());
}

TEST_F(PidDriver, SendsZeroByItselfWhenTheLoopFallsSilent) {
  PidDevice device(bus_);
  ASSERT_TRUE(device.open().ok());
  applyUntilTold(device, {3.0, 0.0, 0.0}, {0x05, 7, 0xFF, 0x7F});
  until([&] { return std::ranges::count(bus_.written(), Bytes{0x05, 7, 0, 0}) > 0; });
}

TEST_F(PidDriver, IsInvalidWhileUnpluggedAndIsSetUpAgainAfterwards) {
  PidDevice device(bus_);
  ASSERT_TRUE(device.open().ok());
  EXPECT_TRUE(device.poll(0.0).valid);
  bus_.plug(false);
  until([&] { return !device.poll(0.0).valid; });
  bus_.written();
  bus_.plug(true);
  until([&] { return device.poll(0.0).valid; });
  EXPECT_EQ(bus_.written().front(), (Bytes{0x0C, 4}));
}

TEST_F(PidDriver, SaysWhatIsWrongWithADeviceThatGrantsNoEffect) {
  bus_.answer([](std::uint8_t) { return Bytes{0x12, 0, 2, 0, 0}; });
  PidDevice device(bus_);
  const Status opened = device.open();
  ASSERT_FALSE(opened.ok());
  EXPECT_NE(opened.error().message.find("memory for effects is full"), std::string::npos);
}

TEST_F(PidDriver, IsListedByItsDescriptor) {
  const auto count = [this] {
    const std::vector<DeviceReport> reports = listDevices(bus_);
    return std::ranges::count(reports, "pid", &DeviceReport::driver);
  };
  EXPECT_EQ(count(), 1);
  bus_.describe({0x05, 0x01, 0x09, 0x04, 0xA1, 0x01, 0xC0});  // a joystick without forces
  EXPECT_EQ(count(), 0);
}

TEST_F(PidDriver, RunsADamperInTheDeviceWhenAskedTo) {
  PidDevice device(bus_, {}, {.damper = 0.5});
  ASSERT_TRUE(device.open().ok());
  const auto features = bus_.features();
  EXPECT_EQ(std::ranges::count(features, Bytes{0x11, 9, 0, 0}), 2);
}

}  // namespace
}  // namespace tandem::haptics
