// The SpaceMouse driver on the real, unmodified libhidapi-hidraw. Only the kernel is played: see
// mock_spacemouse.h.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <glm/geometric.hpp>
#include <thread>

#include "haptics/devices/device_list.h"
#include "haptics/devices/spacemouse.h"
#include "tests/haptics/hid/mock_spacemouse.h"

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
