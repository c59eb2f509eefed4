#include "haptics/devices/haply_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <thread>

#include "haptics/devices/device_list.h"
#include "haptics/devices/haply_codec.h"
#include "tests/support/fake_haply.h"

namespace tandem::haptics {
namespace {

using glm::dvec3;
using testing::FakeHaply;

// --- messages

constexpr const char* kRecorded =
    R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.04,"y":-0.16,"z":0.21},)"
    R"("cursor_velocity":{"x":0.1,"y":0.2,"z":-0.3}}}],"wireless_verse_grip":[{"device_id":"61548","state":)"
    R"({"orientation":{"x":0.0,"y":0.0,"z":0.6,"w":0.8},"buttons":{"a":true,"b":false,"c":true}}}]})";

TEST(HaplyCodec, ReadsAState) {
  HaplyState state;
  ASSERT_EQ(decodeHaply(kRecorded, state), HaplyMessage::kState);
  EXPECT_EQ(state.id, "049D");
  EXPECT_EQ(state.position, dvec3(0.04, -0.16, 0.21));
  EXPECT_EQ(state.velocity, dvec3(0.1, 0.2, -0.3));
  EXPECT_NEAR(state.orientation.z, 0.6, 1e-15);
  EXPECT_EQ(state.buttons, 5u);
}

TEST(HaplyCodec, AxesTurnWithoutAMirror) {
  const dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  EXPECT_EQ(fromHaplyAxes(z), y) << "up";
  EXPECT_EQ(fromHaplyAxes(y), -z) << "away from the user";
  EXPECT_EQ(glm::cross(fromHaplyAxes(x), fromHaplyAxes(y)), fromHaplyAxes(z));
  EXPECT_EQ(toHaplyAxes(fromHaplyAxes(dvec3(1, 2, 3))), dvec3(1, 2, 3));
  const glm::dquat turn = glm::normalize(glm::dquat(0.5, 0.1, -0.4, 0.7));
  const dvec3 v(0.3, -0.2, 0.9);
  EXPECT_LT(glm::distance(fromHaplyAxes(turn * v), fromHaplyAxes(turn) * fromHaplyAxes(v)), 1e-14);
}

TEST(HaplyCodec, DropsWhatMakesNoSense) {
  const HaplyState before;
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = kRecorded;
    return text.replace(text.find(from), from.size(), to);
  };
  for (const std::string& text : {std::string(""),
                                  std::string("{"),
                                  std::string("[]"),
                                  std::string("17"),
                                  std::string("\xff\xfe"),
                                  std::string(R"({"inverse3":{}})"),
                                  std::string(R"({"inverse3":[1]})"),
                                  std::string(R"({"inverse3":[{}]})"),
                                  with("0.04", "1e300"),
                                  with("0.04", "NaN"),
                                  with("0.04", "\"0.04\""),
                                  with("0.04", "null"),
                                  with("0.04", "1e999"),
                                  with("0.1", "1e6"),
                                  with("\"049D\"", "7"),
                                  with("\"049D\"", "\"" + std::string(65, 'a') + "\""),
                                  with("\"w\":0.8", "\"w\":0.0"),
                                  with("\"w\":0.8", "\"w\":\"x\""),
                                  std::string(kMaxHaplyMessage + 1, ' '),
                                  std::string(60000, '[')}) {
    HaplyState state = before;
    EXPECT_EQ(decodeHaply(text, state), HaplyMessage::kMalformed) << text.substr(0, 80);
    EXPECT_EQ(state.position, before.position);
    EXPECT_TRUE(state.id.empty());
  }
  HaplyState state;
  EXPECT_EQ(decodeHaply("{}", state), HaplyMessage::kNoDevice);
  EXPECT_EQ(decodeHaply(R"({"inverse3":[]})", state), HaplyMessage::kNoDevice);
}

TEST(HaplyCodec, WritesForcesThatAreNumbers) {
  EXPECT_EQ(encodeHaply("049D", {1.5, 0.0, -2.0}),
            R"({"inverse3":[{"commands":{"set_cursor_force":{"values":{"x":1.5,"y":0.0,"z":-2.0}}},)"
            R"("device_id":"049D"}]})");
  EXPECT_EQ(FakeHaply::forceIn(encodeHaply("a", {std::nan(""), 1.0, 1.0})), dvec3(0.0));
  EXPECT_FALSE(FakeHaply::forceIn(encodeHaply("", {1.0, 1.0, 1.0})));
}

TEST(HaplyName, NamesAPlaceOrIsRefused) {
  EXPECT_EQ(parseHaplyName("haply")->port, 10001);
  EXPECT_EQ(parseHaplyName("haply")->host, "localhost");
  EXPECT_EQ(parseHaplyName("haply:lab")->host, "lab");
  EXPECT_EQ(parseHaplyName("haply:10.0.0.7:9000")->port, 9000);
  for (const char* bad :
       {"haply:", "haply::1", "haply:lab:", "haply:lab:0", "haply:lab:70000", "haply:lab:1x", "haplyx"})
    EXPECT_FALSE(parseHaplyName(bad).ok()) << bad;
}

// --- the driver, with the service played by the test

class Haply : public ::testing::Test {
 protected:
  Haply() : device_({.host = "127.0.0.1", .port = fake_.port()}) {}

  void open() {
    std::thread service([this] { EXPECT_TRUE(fake_.accept()); });
    const Status opened = device_.open();
    service.join();
    ASSERT_TRUE(opened.ok()) << opened.error().message;
  }
  /// Waits until the driver has taken so many states.
  DeviceSample pollUntilState(std::uint64_t count) {
    for (;;) {
      const DeviceSample sample = device_.poll(0.0);
      if (device_.reading().states >= count) return sample;
      std::this_thread::yield();
    }
  }
  template <typename Condition>
  static void until(Condition condition) {
    while (!condition()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  /// The force that comes back when this state is sent.
  dvec3 answerTo(const std::string& message) {
    const auto answer = fake_.exchange(message);
    if (!answer) return dvec3(std::nan(""));
    return FakeHaply::forceIn(*answer).value_or(dvec3(std::nan("")));
  }

  /// A handle of 0.2 kg that a hand pushes down with 1 N through 4 N·s/m, over a floor of stiffness K at z =
  /// 0 (the service's axes), one millisecond an exchange. The heights of the last fifth of the ticks.
  struct Rest {
    double lowest = 1e9, highest = -1e9;
  };
  Rest pushOntoFloor(double stiffness, int ticks) {
    double z = 0.01, speed = 0.0;
    Rest rest;
    const std::uint64_t before = device_.reading().states;
    for (int tick = 0; tick < ticks; ++tick) {
      const dvec3 force = answerTo(FakeHaply::state({0.0, 0.0, z}, {0.0, 0.0, speed}));
      const double push = -1.0 - 4.0 * speed + force.z;
      speed += push / 0.2 * 1e-3;
      z += speed * 1e-3;
      const DeviceSample sample = pollUntilState(before + static_cast<std::uint64_t>(tick) + 1);
      const double depth = std::max(0.0, -sample.worldFromDevice.position.y);
      device_.apply({{0.0, stiffness * depth, 0.0}, {}});
      if (tick < ticks * 4 / 5) continue;
      rest.lowest = std::min(rest.lowest, z);
      rest.highest = std::max(rest.highest, z);
    }
    return rest;
  }

  FakeHaply fake_;
  HaplyDevice device_;
};

TEST_F(Haply, HandsOutWhereTheHandleIsAndPushesItThere) {
  open();
  // Again and again: on a busy machine the driver's watchdogs may bite between two lines of a test.
  DeviceSample sample;
  until([&] {
    device_.apply({{0.0, 2.0, 0.0}, {}});
    const dvec3 force = answerTo(FakeHaply::state({0.01, 0.02, 0.03}, {0.0, 0.0, 0.5}, true));
    sample = pollUntilState(1);
    return sample.valid && force == dvec3(0.0, 0.0, 2.0);
  });
  EXPECT_EQ(sample.worldFromDevice.position, dvec3(0.01, 0.03, -0.02));
  EXPECT_EQ(sample.twist.linear, dvec3(0.0, 0.5, 0.0));
  EXPECT_EQ(sample.buttons, 1u);
  dvec3 limited(0.0);
  until([&] {
    device_.apply({{300.0, 0.0, 0.0}, {}});
    limited = answerTo(FakeHaply::state({}, {}));
    return limited != dvec3(0.0);
  });
  EXPECT_EQ(limited, dvec3(5.0, 0.0, 0.0));
}

TEST_F(Haply, AHandlePushedOntoAFloorComesToRestWhereTheForcesBalance) {
  open();
  const Rest rest = pushOntoFloor(500.0, 800);
  EXPECT_NEAR(rest.lowest, -1.0 / 500.0, 0.1e-3);
  EXPECT_LT(rest.highest - rest.lowest, 0.1e-3);
}

TEST_F(Haply, WithoutTheFloorOrWithOneFarTooStiffItDoesNotRest) {
  open();
  EXPECT_LT(pushOntoFloor(0.0, 300).highest, -0.02);
  const Rest stiff = pushOntoFloor(20000.0, 800);
  EXPECT_GT(stiff.highest - stiff.lowest, 0.1e-3);
}

TEST_F(Haply, LetsGoWhenTheLoopFallsSilent) {
  open();
  until([&] {
    device_.apply({{0.0, 2.0, 0.0}, {}});
    return answerTo(FakeHaply::state({}, {})).z == 2.0;
  });
  until([&] { return answerTo(FakeHaply::state({}, {})) == dvec3(0.0); });
}

TEST_F(Haply, AReadingThatIsNotRenewedIsNotValid) {
  open();
  EXPECT_FALSE(device_.poll(0.0).valid) << "nothing was said yet";
  answerTo(FakeHaply::state({}, {}));
  until([&] { return !device_.poll(0.0).valid; });
}

TEST_F(Haply, CountsWhatItDropsAnswersItAllTheSameAndGoesOn) {
  open();
  answerTo(FakeHaply::state({0.01, 0.0, 0.0}, {}));
  for (const char* bad :
       {"not json", R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":1e300}}}]})",
        R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":NaN}}}]})"})
    EXPECT_TRUE(fake_.exchange(bad).has_value());
  EXPECT_TRUE(fake_.exchange("{}").has_value());
  answerTo(FakeHaply::state({0.02, 0.0, 0.0}, {}));
  const DeviceSample sample = pollUntilState(2);
  EXPECT_EQ(sample.worldFromDevice.position.x, 0.02);
  EXPECT_EQ(device_.reading().malformed, 3u);
}

TEST_F(Haply, LosesTheServiceAndFindsItAgain) {
  open();
  answerTo(FakeHaply::state({}, {}));
  fake_.drop();
  until([&] { return !device_.poll(0.0).valid && !device_.reading().connected; });
  ASSERT_TRUE(fake_.accept());
  answerTo(FakeHaply::state({0.03, 0.0, 0.0}, {}));
  EXPECT_EQ(pollUntilState(2).worldFromDevice.position.x, 0.03);
  EXPECT_EQ(device_.reading().connections, 2u);
}

TEST_F(Haply, AMessageWithoutEndCostsTheConnectionAndIsCounted) {
  open();
  EXPECT_FALSE(fake_.exchange(std::string(4 * kMaxHaplyMessage, ' ')).has_value());
  until([&] { return device_.poll(0.0).valid || device_.reading().oversized == 1; });
  fake_.drop();
  ASSERT_TRUE(fake_.accept());
  answerTo(FakeHaply::state({}, {}));
  EXPECT_EQ(pollUntilState(1).worldFromDevice.position, dvec3(0.0));
}

TEST_F(Haply, ItsLastAnswerBeforeClosingIsNoForce) {
  open();
  device_.apply({{0.0, 2.0, 0.0}, {}});
  answerTo(FakeHaply::state({}, {}));
  std::thread closing([this] { device_.close(); });
  dvec3 last(1.0);
  while (const auto answer = fake_.exchange(FakeHaply::state({}, {}))) last = *FakeHaply::forceIn(*answer);
  closing.join();
  EXPECT_EQ(last, dvec3(0.0));
  device_.close();  // again: nothing happens
}

TEST_F(Haply, ClosesAtOnceWhenTheServiceIsSilentAndOpensAgain) {
  open();
  device_.close();
  EXPECT_FALSE(device_.poll(0.0).valid);
  fake_.drop();
  open();
  answerTo(FakeHaply::state({0.04, 0.0, 0.0}, {}));
  EXPECT_EQ(pollUntilState(1).worldFromDevice.position.x, 0.04);
}

TEST(HaplyService, ThatIsNotThereIsSaidSo) {
  std::uint16_t port = 0;
  {
    const FakeHaply gone;
    port = gone.port();
  }
  const auto device = openDevice("haply:127.0.0.1:" + std::to_string(port));
  ASSERT_FALSE(device.ok());
  EXPECT_NE(device.error().message.find("no device service at 127.0.0.1"), std::string::npos)
      << device.error().message;
  EXPECT_FALSE(probeHaply({.host = "127.0.0.1", .port = port}).ok());
}

}  // namespace
}  // namespace tandem::haptics
