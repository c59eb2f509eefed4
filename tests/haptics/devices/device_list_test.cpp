#include "haptics/devices/device_list.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "haptics/devices/spacemouse_decoder.h"
#include "haptics/devices/udev_rule.h"
#include "tests/support/source_file.h"

namespace tandem::haptics {
namespace {

TEST(DeviceList, SaysWhoMayOpenANodeAndHowToMendIt) {
  DeviceReport report;
  report.node = "/dev/hidraw7";
  explainAccess({EACCES, 0600, "root", "root"}, report);
  EXPECT_FALSE(report.usable);
  EXPECT_NE(report.reason.find("/dev/hidraw7 has mode 0600, owner root:root"), std::string::npos)
      << report.reason;
  ASSERT_EQ(report.remedy.size(), 2u);
  EXPECT_EQ(report.remedy[0], "tandem devices --udev-rule | sudo tee /etc/udev/rules.d/70-tandem-hid.rules");
  explainAccess({EBUSY, 0660, "root", "root"}, report);
  EXPECT_NE(report.reason.find("busy"), std::string::npos);
  explainAccess({ENODEV, 0, "", ""}, report);
  EXPECT_NE(report.reason.find("unplugged"), std::string::npos);
  explainAccess({}, report);
  EXPECT_TRUE(report.usable);
  EXPECT_TRUE(report.reason.empty() && report.remedy.empty());
}

TEST(DeviceList, AMissingNodeIsGone) { EXPECT_EQ(checkNode("/dev/no_such_node").error, ENOENT); }

TEST(DeviceList, TheUdevRuleCoversEveryModel) {
  std::ifstream file(sourceFile("haptics/devices/70-tandem-hid.rules"));
  const std::string rule((std::istreambuf_iterator<char>(file)), {});
  ASSERT_FALSE(rule.empty());
  EXPECT_EQ(udevRule(), rule);  // what the program prints is what is shipped
  for (const SpaceMouseModel& model : spaceMouseModels()) {
    char vendor[40], product[8];
    std::snprintf(vendor, sizeof vendor, "ATTRS{idVendor}==\"%04x\"", model.vendor);
    std::snprintf(product, sizeof product, "%04x", model.product);
    EXPECT_NE(rule.find(vendor), std::string::npos) << model.name;
    if (model.vendor == 0x046d) {
      EXPECT_NE(rule.find(product), std::string::npos) << model.name;
    }
  }
}

TEST(DeviceList, OpensTheBuiltInDevicesAndRefusesUnknownNames) {
  for (const char* name : {"stylus", "simulated", "none"}) {
    auto device = openDevice(name);
    ASSERT_TRUE(device.ok());
    EXPECT_EQ((*device)->name(), name);
  }
  const auto unknown = openDevice("teapot");
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().message.find("'teapot'"), std::string::npos);
}

TEST(DeviceList, TestsADeviceAndStopsWhenAsked) {
  auto device = openDevice("simulated");
  ASSERT_TRUE(device.ok());
  int calls = 0;
  const DeviceTestState state =
      testDevice(**device, 60.0, [&calls](const DeviceTestState&) { return ++calls < 3; });
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(state.valid, state.ticks);
  EXPECT_GT(state.ticks, 0u);
}

}  // namespace
}  // namespace tandem::haptics
