// The SpaceMouse driver on the real, unmodified libhidapi-hidraw. Only the kernel is played: see
// mock_spacemouse.h.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <glm/geometric.hpp>
#include <thread>
#include <vector>

#include "haptics/devices/device_list.h"
#include "haptics/devices/dualsense_codec.h"
#include "haptics/devices/spacemouse.h"
#include "tests/haptics/devices/hid/mock_spacemouse.h"
#include "tests/support/pid_descriptor.h"

namespace tandem::haptics {
namespace {

constexpr int kSkipped = 77;  // CTest's SKIP_RETURN_CODE

constexpr std::array<std::uint8_t, 7> kFullRight{1, 0x5e, 0x01, 0, 0, 0, 0};  // X = 350
constexpr std::array<std::uint8_t, 7> kFullYaw{2, 0, 0, 0, 0, 0x5e, 0x01};    // RZ = 350
constexpr std::array<std::uint8_t, 5> kMenuPressed{3, 1, 0, 0, 0};
constexpr std::array<std::uint8_t, 3> kUnknown{0x55, 1, 2};
const std::vector<std::uint8_t> kLightOn{4, 1}, kLightOff{4, 0};

class Hidapi : public ::testing::Test {
 protected:
  /// Ticks of 1 ms on a clock of the test's own.
  DeviceSample tick(Device& device, int ticks) {
    DeviceSample sample;
    for (int i = 0; i < ticks; ++i) {
      sample = device.poll(now_ += 0.001);
      device.apply({});
    }
    return sample;
  }

  /// Looks for at most five seconds of real time whether something has come true.
  template <typename Predicate>
  static bool eventually(Predicate predicate) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (!predicate()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }

  /// The same report every 8 ms, as from a cap that is held over.
  DeviceSample hold(Device& device, std::span<const std::uint8_t> report, int times) {
    DeviceSample sample;
    for (int i = 0; i < times; ++i) {
      EXPECT_TRUE(bus_.deliver(report));
      sample = tick(device, 8);
    }
    return sample;
  }

  static std::vector<DeviceReport> spaceMice() {
    std::vector<DeviceReport> reports = listDevices();
    std::erase_if(reports, [](const DeviceReport& report) { return report.driver != "spacemouse"; });
    return reports;
  }

  testing::MockBus bus_;
  double now_ = 0.0;
};

TEST_F(Hidapi, AnEmptyBusListsNoSpaceMouseAndSaysSo) {
  EXPECT_TRUE(spaceMice().empty());
  const auto device = openDevice("spacemouse");
  ASSERT_FALSE(device.ok());
  EXPECT_NE(device.error().message.find("none is connected"), std::string::npos) << device.error().message;
}

TEST_F(Hidapi, ListsAPluggedInSpaceMouseAsUsable) {
  ASSERT_TRUE(bus_.plug(3));
  const auto found = spaceMice();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].vendor, 0x046d);
  EXPECT_EQ(found[0].product, 0xc62b);
  EXPECT_EQ(found[0].node, "/dev/hidraw3");
  EXPECT_EQ(found[0].name, "SpaceMouse Pro");
  EXPECT_TRUE(found[0].usable) << found[0].reason;

  const auto interfaces = systemHidBus().enumerate();
  ASSERT_EQ(interfaces.size(), 1u);
  EXPECT_EQ(interfaces[0].usagePage, 1);
  EXPECT_EQ(interfaces[0].usage, 8);
  EXPECT_EQ(interfaces[0].productName, "SpaceMouse Pro");

  bus_.unplug();
  EXPECT_TRUE(spaceMice().empty());
}

TEST_F(Hidapi, AReportMovesTheStylusAndTheLightShowsWhoIsInUse) {
  ASSERT_TRUE(bus_.plug(0));
  auto opened = openDevice("spacemouse", Pose{});
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  Device& device = **opened;
  EXPECT_EQ(bus_.written(2), kLightOn);

  const DeviceSample still = tick(device, 200);
  EXPECT_TRUE(still.valid);
  EXPECT_NEAR(glm::length(still.worldFromDevice.position), 0.0, 1e-9);

  const DeviceSample moved = hold(device, kFullRight, 30);
  const glm::dvec3 way = moved.worldFromDevice.position;
  EXPECT_GT(way.x, 0.005);
  EXPECT_LT(way.x, 0.05);  // 0.24 s at 0.15 m/s
  EXPECT_NEAR(way.y, 0.0, 1e-6);
  EXPECT_NEAR(way.z, 0.0, 1e-6);
  EXPECT_EQ(moved.buttons, 0u);

  // Again and again: on a busy machine a report may still run together with the one before.
  EXPECT_TRUE(eventually([&] { return bus_.deliver(kMenuPressed) && tick(device, 1).buttons == 1; }));
  // Nothing more is sent: 0.1 s later the hand comes to rest.
  tick(device, 1500);
  const DeviceSample resting = tick(device, 1);
  EXPECT_LT(glm::length(resting.twist.linear), 1e-4);
  EXPECT_TRUE(resting.valid);

  device.close();
  EXPECT_EQ(bus_.written(2), kLightOff);
}

TEST_F(Hidapi, AYawReportTurnsTheStylus) {
  ASSERT_TRUE(bus_.plug(0));
  auto opened = openDevice("spacemouse", Pose{});
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  const DeviceSample turned = hold(**opened, kFullYaw, 30);
  // RZ points down, so positive yaw turns the view's up axis backwards.
  EXPECT_LT(turned.worldFromDevice.orientation.y, -0.02);
  EXPECT_NEAR(glm::length(turned.worldFromDevice.position), 0.0, 1e-6);
}

TEST_F(Hidapi, CountsAnUnknownReportAndGoesOn) {
  ASSERT_TRUE(bus_.plug(0));
  SpaceMouseReader reader(systemHidBus());
  ASSERT_TRUE(reader.open().ok());
  ASSERT_TRUE(bus_.deliver(kUnknown));
  ASSERT_TRUE(eventually([&] { return reader.reading().rejected == 1; }));
  ASSERT_TRUE(bus_.deliver(kMenuPressed));
  ASSERT_TRUE(eventually([&] { return reader.reading().reports == 1; }));
  EXPECT_EQ(reader.reading().rejected, 1u);
  EXPECT_EQ(reader.reading().state.buttons, 1u);
}

TEST_F(Hidapi, UnpluggedItIsInvalidAndPluggedInElsewhereItGoesOnFromWhereTheHandIs) {
  ASSERT_TRUE(bus_.plug(0));
  auto opened = openDevice("spacemouse", Pose{});
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  Device& device = **opened;
  EXPECT_EQ(bus_.written(2), kLightOn);
  ASSERT_TRUE(hold(device, kFullRight, 20).valid);

  bus_.unplug();
  ASSERT_TRUE(eventually([&] { return !tick(device, 1).valid; })) << "it did not notice the loss";
  const DeviceSample lost = tick(device, 1500);
  EXPECT_FALSE(lost.valid);
  EXPECT_EQ(lost.buttons, 0u);
  const double before = lost.worldFromDevice.position.x;
  ASSERT_GT(before, 0.001);

  ASSERT_TRUE(bus_.plug(5));  // another port
  ASSERT_TRUE(eventually([&] { return tick(device, 1).valid; })) << "it was not found again";
  EXPECT_EQ(bus_.written(2), kLightOn);
  EXPECT_NEAR(tick(device, 1).worldFromDevice.position.x, before, 1e-3);
  EXPECT_GT(hold(device, kFullRight, 20).worldFromDevice.position.x, before + 0.002);
}

TEST_F(Hidapi, ANodeWithoutPermissionIsListedWithItsReasonAndRemedy) {
  ASSERT_TRUE(bus_.plug(0));
  ASSERT_TRUE(bus_.setMode(0));
  {
    const testing::WithoutRootOverride unprivileged;
    const auto found = spaceMice();
    ASSERT_EQ(found.size(), 1u);
    EXPECT_FALSE(found[0].usable);
    EXPECT_NE(found[0].reason.find("permission denied: /dev/hidraw0 has mode 0000"), std::string::npos)
        << found[0].reason;
    EXPECT_FALSE(found[0].remedy.empty());
    const auto device = openDevice("spacemouse");
    ASSERT_FALSE(device.ok());
    EXPECT_NE(device.error().message.find("permission denied"), std::string::npos) << device.error().message;
  }
  ASSERT_TRUE(bus_.setMode(0600));
  const auto found = spaceMice();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].usable) << found[0].reason;
}

using Bytes = std::vector<std::uint8_t>;

TEST_F(Hidapi, AForceFeedbackJoystickIsFoundByItsDescriptorSetUpAndPushed) {
  const auto grant = [](std::uint8_t id) { return id == 0x12 ? Bytes{0x12, 7, 1, 0, 0} : Bytes{}; };
  ASSERT_TRUE(bus_.plug(1, {0x1209, 0xffb0, "FFB joystick", testing::PidDescriptor().bytes(), grant}));
  const auto reports = listDevices();
  EXPECT_EQ(std::ranges::count(reports, "pid", &DeviceReport::driver), 1);

  auto opened = openDevice("pid");
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  Device& device = **opened;
  EXPECT_EQ(bus_.features(), (std::vector<Bytes>{{0x11, 1, 0, 0}, {0x11, 1, 0, 0}}));
  // Reset, actuators on, full gain, then an effect an axis: set, no force, start.
  const Bytes start = bus_.written(2 + 2 + 2 + 2 * (18 + 4 + 4));
  ASSERT_EQ(start.size(), 58u);
  EXPECT_EQ((Bytes(start.begin(), start.begin() + 6)), (Bytes{0x0C, 4, 0x0C, 1, 0x0D, 0xFF}));
  EXPECT_EQ((Bytes(start.begin() + 24, start.begin() + 32)), (Bytes{0x05, 7, 0, 0, 0x0A, 7, 1, 1}));

  ASSERT_TRUE(bus_.deliver(Bytes{0x01, 0x01, 0, 0xFF, 0x7F, 0, 0}));
  EXPECT_TRUE(eventually([&] { return tick(device, 1).buttons == 1; }));
  EXPECT_NEAR(device.poll(now_).worldFromDevice.position.x, 0.05, 1e-6);

  Bytes written;
  EXPECT_TRUE(eventually([&] {
    device.apply({{-1.5, 0.0, 0.0}, {}});
    const Bytes more = bus_.written(1);
    written.insert(written.end(), more.begin(), more.end());
    const Bytes push{0x05, 7, 0x00, 0xC0};
    return std::search(written.begin(), written.end(), push.begin(), push.end()) != written.end();
  }));
  device.close();
}

TEST_F(Hidapi, AJoystickThatStallsIsRefusedWithTheReason) {
  ASSERT_TRUE(bus_.plug(1, {0x1209, 0xffb0, "FFB joystick", testing::PidDescriptor().bytes(), {}}));
  auto opened = openDevice("pid");
  ASSERT_FALSE(opened.ok());
  EXPECT_NE(opened.error().message.find("feature report not given"), std::string::npos)
      << opened.error().message;
}

TEST_F(Hidapi, ADualSenseSteersAndItsTriggersResist) {
  // Generic desktop, gamepad; one input and one output report of the sizes that the controller has over USB.
  const Bytes descriptor{0x05, 0x01, 0x09, 0x05, 0xA1, 0x01, 0x85, 0x01, 0x06, 0x00, 0xFF,
                         0x09, 0x20, 0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08, 0x95, 0x3F,
                         0x81, 0x02, 0x85, 0x02, 0x09, 0x21, 0x95, 0x2F, 0x91, 0x02, 0xC0};
  ASSERT_TRUE(bus_.plug(2, {0x054c, 0x0ce6, "DualSense Wireless Controller", descriptor, {}}));
  const auto reports = listDevices();
  EXPECT_EQ(std::ranges::count(reports, "dualsense", &DeviceReport::driver), 1);
  auto opened = openDevice("dualsense", Pose{});
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  Device& device = **opened;
  Bytes report(64, 0);
  report[0] = 0x01;
  report[1] = 0xFF, report[2] = report[3] = report[4] = 0x80;  // left stick to the right
  report[8] = 0x28;                                            // cross
  ASSERT_TRUE(bus_.deliver(report));
  EXPECT_TRUE(eventually([&] { return tick(device, 1).buttons == 1; }));
  EXPECT_GT(tick(device, 200).worldFromDevice.position.x, 0.01);

  const Bytes resist = encodeDualSense({0, 0, 255, 255}, false, 0);
  Bytes written;
  EXPECT_TRUE(eventually([&] {
    for (int i = 0; i < 20; ++i) device.poll(now_ += 0.001), device.apply({{3.3, 0.0, 0.0}, {}});
    const Bytes more = bus_.written(1);
    written.insert(written.end(), more.begin(), more.end());
    return std::search(written.begin(), written.end(), resist.begin(), resist.end()) != written.end();
  }));
  device.close();
}

}  // namespace
}  // namespace tandem::haptics

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (!tandem::haptics::testing::mockedBusAvailable()) {
    std::puts("skipped: needs umockdev, run it as: umockdev-wrapper tests_hid");
    return tandem::haptics::kSkipped;
  }
  return RUN_ALL_TESTS();
}
