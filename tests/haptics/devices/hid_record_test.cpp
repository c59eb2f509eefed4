#include "haptics/devices/hid_record.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>
#include <thread>

#include "haptics/devices/spacemouse.h"
#include "tests/support/scripted_hid.h"

namespace tandem::haptics {
namespace {

using Bytes = std::vector<std::uint8_t>;

const HidInfo kSpaceMouse{"/dev/hidraw1",        0x256f,   0xc635, "3Dconnexion",
                          "SpaceMouse\nCompact", "secret", 1,      8};
const std::vector<Bytes> kStroke{{1, 0x5e, 0x01, 0, 0, 0, 0}, {3, 1, 0}, {9, 9}};

/// Reads until the driver has taken `count` reports, known or not; the last reading if it does not in 10 s.
template <typename Reader>
SpaceMouseReading after(Reader& reader, std::uint64_t count) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  for (;;) {
    const SpaceMouseReading reading = reader.reading();
    const std::uint64_t taken = reading.reports + reading.rejected;
    if (taken >= count || std::chrono::steady_clock::now() > deadline) {
      EXPECT_EQ(taken, count);
      return reading;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

TEST(HidRecord, WhatADeviceSentIsReplayedToTheSameEffect) {
  const std::string path = ::testing::TempDir() + "tandem_hid_" + std::to_string(::getpid());
  testing::ScriptedHid bus(kSpaceMouse);
  bus.describe({0x05, 0x01, 0x09, 0x08});
  auto recorder = RecordingHidBus::create(bus, path);
  ASSERT_TRUE(recorder.ok());
  SpaceMouseReading felt;
  {
    SpaceMouseReader reader(**recorder);
    ASSERT_TRUE(reader.open().ok());
    for (const Bytes& report : kStroke) bus.send(report);
    felt = after(reader, kStroke.size());
  }
  EXPECT_EQ((*recorder)->finish().value(), kStroke.size());

  std::ifstream file(path);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  std::remove(path.c_str());
  EXPECT_EQ(text.find("secret"), std::string::npos) << "a serial number is nobody's business";
  const Result<HidRecording> recording = parseHidRecording(text, "recording");
  ASSERT_TRUE(recording.ok()) << recording.error().message;
  EXPECT_EQ(recording->info.vendor, 0x256f);
  EXPECT_EQ(recording->info.productName, "SpaceMouse Compact");
  EXPECT_EQ(recording->descriptor, (Bytes{0x05, 0x01, 0x09, 0x08}));
  ASSERT_EQ(recording->reports.size(), kStroke.size());
  for (std::size_t i = 0; i < kStroke.size(); ++i) {
    EXPECT_EQ(recording->reports[i].bytes, kStroke[i]);
    EXPECT_GE(recording->reports[i].time, i > 0 ? recording->reports[i - 1].time : 0.0);
  }

  testing::ScriptedHid again(recording->info);
  SpaceMouseReader reader(again);
  ASSERT_TRUE(reader.open().ok());
  for (const HidRecording::Report& report : recording->reports) again.send(report.bytes);
  const SpaceMouseReading replayed = after(reader, kStroke.size());
  EXPECT_EQ(replayed.state.axes, felt.state.axes);
  EXPECT_EQ(replayed.state.buttons, 1u);
  EXPECT_EQ(replayed.rejected, 1u);
}

TEST(HidRecord, KeepsFeatureReports) {
  const std::string path = ::testing::TempDir() + "tandem_hid_feature_" + std::to_string(::getpid());
  testing::ScriptedHid bus(kSpaceMouse);
  bus.answer([](std::uint8_t id) { return Bytes{id, 7}; });
  auto recorder = RecordingHidBus::create(bus, path);
  ASSERT_TRUE(recorder.ok());
  {
    auto connection = (*recorder)->open(kSpaceMouse.path);
    ASSERT_TRUE(connection.ok());
    Bytes asked(8, 5);
    EXPECT_EQ((*connection)->getFeature(asked).value(), 2u);
  }
  EXPECT_EQ((*recorder)->finish().value(), 0u);
  std::ifstream file(path);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  std::remove(path.c_str());
  EXPECT_EQ(parseHidRecording(text, "r").value().features, (std::vector<Bytes>{{5, 7}}));
}

TEST(HidRecord, RefusesWhatIsNone) {
  const std::string device = "device 256f:c635 1:8 x\n";
  EXPECT_TRUE(parseHidRecording(device, "r").ok());
  for (const std::string& text :
       {std::string(), std::string("in 0.1 01\n"), device + "in nan 01\n", device + "in 0.1 0\n",
        device + "in 0.1 0g\n", device + "in 0.1\n", device + "out 0.1 01\n",
        device + "descriptor " + std::string(9000, '0') + "\n", std::string("device x\n")})
    EXPECT_FALSE(parseHidRecording(text, "r").ok()) << text.substr(0, 60);
  EXPECT_NE(parseHidRecording(device + "in 0.1 0\n", "r").error().message.find("r, line 2"),
            std::string::npos);
  EXPECT_FALSE(RecordingHidBus::create(systemHidBus(), "/no/such/folder/r").ok());
}

TEST(HidRecord, AnyTextIsReadOrRefused) {
  std::mt19937 random(11);
  const std::string alphabet = "device in feature 0123456789abcdef:.\n ";
  for (int i = 0; i < 20'000; ++i) {
    std::string text = i % 2 ? "device 256f:c635 1:8 x\n" : "";
    for (std::size_t n = random() % 80; n > 0; --n) text += alphabet[random() % alphabet.size()];
    if (const auto read = parseHidRecording(text, "r")) {
      for (const HidRecording::Report& report : read->reports) ASSERT_FALSE(report.bytes.empty());
    }
  }
}

}  // namespace
}  // namespace tandem::haptics
