#include "haptics/devices/spacemouse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <glm/geometric.hpp>
#include <limits>
#include <mutex>
#include <random>
#include <thread>

#include "haptics/devices/device_list.h"

namespace tandem::haptics {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A bus with at most one device on it, whose reports the test writes.
class ScriptedBus : public HidBus {
 public:
  std::vector<HidInfo> enumerate() override {
    const std::lock_guard lock(mutex_);
    HidInfo keyboard{"/dev/hidraw0", 0x256f, 0xc635, "", "keyboard interface", "", 1, 6};
    HidInfo motion{path_, 0x256f, 0xc635, "3Dconnexion", "SpaceMouse Compact", "", 1, 8};
    return plugged_ ? std::vector{keyboard, motion} : std::vector<HidInfo>{};
  }
  Result<std::unique_ptr<HidConnection>> open(const std::string& path) override {
    const std::lock_guard lock(mutex_);
    if (denied_ && ++attempts_ > allowedAfter_) denied_ = false;
    if (denied_) return Error{path + ": Permission denied"};
    return std::unique_ptr<HidConnection>(std::make_unique<Connection>(*this, path));
  }
  bool forbids(const std::string&) override {
    const std::lock_guard lock(mutex_);
    return denied_;
  }
  bool present(const std::string& path) override {
    const std::lock_guard lock(mutex_);
    return plugged_ && path == path_;
  }

  void send(Bytes report) {
    const std::lock_guard lock(mutex_);
    reports_.push_back(std::move(report));
  }
  void plug(bool plugged, const std::string& path = "/dev/hidraw1") {
    const std::lock_guard lock(mutex_);
    plugged_ = plugged;
    path_ = path;
  }
  /// The node may not be opened, but for the attempts after so many.
  void deny(int attempts = 1 << 30) {
    const std::lock_guard lock(mutex_);
    denied_ = true;
    attempts_ = 0;
    allowedAfter_ = attempts;
  }
  int attempts() {
    const std::lock_guard lock(mutex_);
    return attempts_;
  }
  std::vector<Bytes> written() {
    const std::lock_guard lock(mutex_);
    return written_;
  }

 private:
  class Connection : public HidConnection {
   public:
    Connection(ScriptedBus& bus, std::string path) : bus_(bus), path_(std::move(path)) {}
    int read(std::span<std::uint8_t> buffer, int) override {
      if (!bus_.present(path_)) return -1;
      {
        const std::lock_guard lock(bus_.mutex_);
        if (!bus_.reports_.empty()) {
          const Bytes report = bus_.reports_.front();
          bus_.reports_.pop_front();
          std::copy(report.begin(), report.end(), buffer.begin());
          return static_cast<int>(report.size());
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return 0;
    }
    Status write(std::span<const std::uint8_t> report) override {
      const std::lock_guard lock(bus_.mutex_);
      bus_.written_.emplace_back(report.begin(), report.end());
      return {};
    }

   private:
    ScriptedBus& bus_;
    std::string path_;
  };

  std::mutex mutex_;
  bool plugged_ = true;
  bool denied_ = false;
  int attempts_ = 0, allowedAfter_ = 0;  // while denied
  std::string path_ = "/dev/hidraw1";
  std::deque<Bytes> reports_;
  std::vector<Bytes> written_;
};

/// Polls without letting time pass until the reading meets a condition.
template <typename Condition>
DeviceSample pollUntil(SpaceMouse& device, double now, Condition condition) {
  for (;;) {
    const DeviceSample sample = device.poll(now);
    if (condition(sample)) return sample;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

const Bytes kFullRight{1, 0x5e, 0x01, 0, 0, 0, 0};  // x = +350
const Bytes kGraspButton{3, 1, 0};

TEST(SpaceMouseDecoder, ReadsTranslationAndRotationInTwoReports) {
  SpaceMouseState state;
  EXPECT_TRUE(decodeSpaceMouseReport(Bytes{1, 0x5e, 0x01, 0xa2, 0xfe, 0xaf, 0x00}, state));
  EXPECT_TRUE(decodeSpaceMouseReport(Bytes{2, 0x00, 0x00, 0x51, 0xff, 0x5e, 0x01}, state));
  EXPECT_DOUBLE_EQ(state.axes[0], 1.0);
  EXPECT_DOUBLE_EQ(state.axes[1], -1.0);
  EXPECT_DOUBLE_EQ(state.axes[2], 0.5);
  EXPECT_DOUBLE_EQ(state.axes[3], 0.0);
  EXPECT_DOUBLE_EQ(state.axes[4], -0.5);
  EXPECT_DOUBLE_EQ(state.axes[5], 1.0);
}

TEST(SpaceMouseDecoder, ReadsAllSixAxesInOneLongReport) {
  SpaceMouseState state;
  EXPECT_TRUE(decodeSpaceMouseReport(Bytes{1, 0xaf, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0x7f}, state));
  EXPECT_DOUBLE_EQ(state.axes[0], 0.5);
  EXPECT_DOUBLE_EQ(state.axes[5], 1.0) << "beyond the nominal range counts as full";
}

TEST(SpaceMouseDecoder, ReadsButtonsOfOneToFourBytesAndTheBattery) {
  SpaceMouseState state;
  EXPECT_TRUE(decodeSpaceMouseReport(Bytes{3, 0x02}, state));
  EXPECT_EQ(state.buttons, 2u);
  EXPECT_TRUE(decodeSpaceMouseReport(Bytes{3, 0x01, 0xf0, 0xc0, 0x07}, state));
  EXPECT_EQ(state.buttons, 0x07c0f001u);
  EXPECT_TRUE(decodeSpaceMouseReport(Bytes{0x17, 80}, state));
  EXPECT_EQ(state.battery, 80);
}

TEST(SpaceMouseDecoder, RefusesShortAndUnknownReportsUntouched) {
  SpaceMouseState state;
  state.axes[0] = 0.25;
  for (const Bytes& report : {Bytes{}, Bytes{1}, Bytes{1, 0, 0, 0, 0, 0}, Bytes{2, 1}, Bytes{3},
                              Bytes{0x17, 101}, Bytes{9, 1, 2, 3, 4, 5, 6}})
    EXPECT_FALSE(decodeSpaceMouseReport(report, state));
  EXPECT_EQ(state.axes[0], 0.25);
  EXPECT_EQ(state.buttons, 0u);
}

TEST(SpaceMouseDecoder, AnyBytesGiveAxesWithinTheFullDeflection) {
  std::mt19937 random(7);
  SpaceMouseState state;
  for (int i = 0; i < 200'000; ++i) {
    Bytes report(random() % 65);
    for (std::uint8_t& byte : report) byte = static_cast<std::uint8_t>(random());
    if (!report.empty() && random() % 2) report[0] = static_cast<std::uint8_t>(1 + random() % 3);
    decodeSpaceMouseReport(report, state);
    for (const double axis : state.axes) ASSERT_LE(std::abs(axis), 1.0);
    ASSERT_LE(state.battery, 100);
  }
}

TEST(SpaceMouseVelocity, IsZeroInTheDeadZoneAndFullAtTheEnd) {
  const VelocityCurve curve;
  const glm::dquat level(1.0, 0.0, 0.0, 0.0);
  EXPECT_EQ(twistFromDeflection({0.05, -0.05, 0.0, 0.05, 0.0, 0.0}, curve, level).linear,
            glm::dvec3(0.0, 0.0, 0.0));
  double last = 0.0;
  for (double x = 0.07; x <= 1.0; x += 0.01) {
    const double speed = twistFromDeflection({x, 0, 0, 0, 0, 0}, curve, level).linear.x;
    EXPECT_GT(speed, last);
    last = speed;
  }
  EXPECT_NEAR(twistFromDeflection({1, 0, 0, 0, 0, 0}, curve, level).linear.x, curve.maxSpeed, 1e-12);
}

TEST(SpaceMouseVelocity, PointsWhereTheHandPushes) {
  const VelocityCurve curve;
  const glm::dquat level(1.0, 0.0, 0.0, 0.0);
  EXPECT_GT(twistFromDeflection({0, 0, -1, 0, 0, 0}, curve, level).linear.y, 0.0) << "pulled up";
  EXPECT_GT(twistFromDeflection({0, 1, 0, 0, 0, 0}, curve, level).linear.z, 0.0) << "pulled towards the user";
  EXPECT_GT(twistFromDeflection({0, 0, 0, 0, 0, -1}, curve, level).angular.y, 0.0)
      << "turned left, seen from above";
  const glm::dquat side = fromRotationVector({0.0, 1.5707963267948966, 0.0});
  EXPECT_LT(twistFromDeflection({1, 0, 0, 0, 0, 0}, curve, side).linear.z, -0.1) << "right of a turned view";
}

TEST(SpaceMouse, MovesTheHandAtTheSpeedOfItsDeflectionUntilSilence) {
  ScriptedBus bus;
  SpaceMouse device(bus);
  ASSERT_TRUE(device.open().ok());
  device.poll(0.0);
  bus.send(kGraspButton);
  double now = 0.0;
  pollUntil(device, now, [](const DeviceSample& s) { return s.buttons == 1; });
  bus.send(kFullRight);
  while (bus.send(kFullRight), now < 1.0) {  // one report a tick keeps it from falling silent
    now += 1e-3;
    std::this_thread::sleep_for(std::chrono::microseconds(1500));
    device.poll(now);
    device.apply({});
  }
  const double reached = device.hand().devicePose().position.x;
  EXPECT_GT(reached, 0.05);
  EXPECT_LT(reached, 0.16);
  // Drain what is queued, without time, then stay silent.
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  device.poll(now);
  for (int i = 0; i < 2000; ++i) {
    device.poll(now += 1e-3);
    device.apply({});
  }
  EXPECT_LT(glm::length(device.hand().deviceVelocity()), 1e-3) << "silence is standstill";
  EXPECT_LT(device.hand().devicePose().position.x, reached + 0.05);
  EXPECT_EQ(device.poll(now).buttons, 1u) << "a pressed button needs no report to stay pressed";
}

TEST(SpaceMouse, IsNotValidWhileUnpluggedAndGoesOnAtAnotherPort) {
  ScriptedBus bus;
  SpaceMouse device(bus, Pose{{0.1, 0.2, 0.3}, glm::dquat(1.0, 0.0, 0.0, 0.0)});
  ASSERT_TRUE(device.open().ok());
  bus.send(kGraspButton);
  EXPECT_TRUE(pollUntil(device, 0.0, [](const DeviceSample& s) { return s.buttons == 1; }).valid);
  bus.plug(false);
  EXPECT_EQ(pollUntil(device, 0.01, [](const DeviceSample& s) { return !s.valid; }).buttons, 0u);
  bus.plug(true, "/dev/hidraw5");
  const DeviceSample back = pollUntil(device, 0.02, [](const DeviceSample& s) { return s.valid; });
  EXPECT_LT(glm::length(back.worldFromDevice.position - glm::dvec3(0.1, 0.2, 0.3)), 1e-4);
}

TEST(SpaceMouse, LightsUpWhileOpen) {
  ScriptedBus bus;
  {
    SpaceMouse device(bus);
    ASSERT_TRUE(device.open().ok());
    device.close();
    device.close();
  }
  EXPECT_EQ(bus.written(), (std::vector<Bytes>{{4, 1}, {4, 0}}));
}

TEST(SpaceMouse, SaysWhyItCannotBeOpened) {
  ScriptedBus bus;
  bus.deny();
  EXPECT_NE(SpaceMouse(bus).open().error().message.find("/dev/hidraw1: Permission denied"),
            std::string::npos);
  bus.plug(false);
  EXPECT_NE(SpaceMouse(bus).open().error().message.find("none is connected"), std::string::npos);
}

TEST(SpaceMouse, OpensOnceUdevHasSetThePermissionsOfANewNode) {
  ScriptedBus bus;
  bus.deny(2);
  SpaceMouse device(bus);
  EXPECT_TRUE(device.open().ok());
  EXPECT_EQ(bus.attempts(), 3);
}

TEST(SpaceMouse, NamesTheRuleThatIsMissing) {
  ScriptedBus bus;
  bus.deny();
  EXPECT_NE(SpaceMouse(bus).open().error().message.find("tandem devices --udev-rule"), std::string::npos);
  EXPECT_GT(bus.attempts(), 1);
}

TEST(SpaceMouse, PluggedInAgainWithoutPermissionItSaysSoOnceAndGoesOnTrying) {
  ScriptedBus bus;
  SpaceMouse device(bus);
  ASSERT_TRUE(device.open().ok());
  ::testing::internal::CaptureStderr();
  bus.plug(false);
  pollUntil(device, 0.01, [](const DeviceSample& s) { return !s.valid; });
  bus.deny(8);
  bus.plug(true, "/dev/hidraw5");
  EXPECT_TRUE(pollUntil(device, 0.02, [](const DeviceSample& s) { return s.valid; }).valid);
  device.close();
  const std::string printed = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::ranges::count(printed, '\n'), 1) << printed;
  EXPECT_NE(printed.find("/dev/hidraw5: Permission denied"), std::string::npos) << printed;
}

TEST(SpaceMouse, IsListedOnceByItsMotionInterface) {
  ScriptedBus bus;
  bus.plug(true, "/dev/no_such_node");
  const std::vector<DeviceReport> reports = listDevices(bus);
  EXPECT_EQ(std::ranges::count(reports, "spacemouse", &DeviceReport::driver), 1);
  const DeviceReport& report = reports.back();
  EXPECT_EQ(report.name, "SpaceMouse Compact");
  EXPECT_EQ(report.driver, "spacemouse");
  EXPECT_FALSE(report.usable);
  EXPECT_FALSE(report.reason.empty());
}

}  // namespace
}  // namespace tandem::haptics
