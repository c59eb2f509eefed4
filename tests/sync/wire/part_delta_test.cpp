// A part's state as a difference: exact, small for what a hand does, and harmless whatever the bytes are.

#include "sync/wire/part_delta.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sync/wire/random_messages.h"

namespace tandem::sync {
namespace {

using testing::RandomMessages;
const WireFrame kDeltaFrame{{0.3, -1.0, 2.0}, 2.0};

PartCode codeOf(const PartState& state) {
  int clamped = 0;
  return toCode(state, kDeltaFrame, clamped);
}

struct Encoded {
  int bits = 0;
  DeltaOrders orders{};
};
/// Encodes a difference and decodes it again.
Encoded roundTrip(const PartBaseline& baseline, Micros elapsed, const PartCode& now) {
  std::vector<std::byte> bytes(400);
  BitWriter writer(bytes);
  const DeltaOrders orders = putDelta(writer, baseline, elapsed, now, kDeltaFrame);
  EXPECT_FALSE(writer.overflowed());
  EXPECT_EQ(static_cast<int>(writer.bitCount()), deltaBits(baseline, elapsed, now, kDeltaFrame));
  PartCode back = baseline.code;
  back.sequence = now.sequence;
  back.epoch = now.epoch;
  back.part = now.part;
  BitReader reader(bytes);
  EXPECT_EQ(getDelta(reader, baseline, elapsed, kDeltaFrame, back), orders);
  EXPECT_FALSE(reader.failed());
  EXPECT_EQ(back, now);
  return {static_cast<int>(writer.bitCount()), orders};
}

TEST(PartDelta, AnyStateComesBackExactlyFromAnyOther) {
  RandomMessages random(21);
  for (int round = 0; round < 20000; ++round) {
    const auto parts = random.update(3, kDeltaFrame).parts;
    PartBaseline baseline{
        codeOf(parts[0]), random.chance(0.5), codeOf(parts[1]).twist, 1 + random.number(2000000), {}};
    for (int& order : baseline.orders) order = static_cast<int>(random.number(16));
    roundTrip(baseline, 1 + random.number(kLongestElapsed), codeOf(parts[2]));
  }
}

/// Minimum-jerk strokes between random places (Flash and Hogan 1985), each with a turn about a random axis,
/// with the tremor of a hand, 10 Hz, on top.
class HandMotion {
 public:
  HandMotion(std::uint64_t seed, double length, double turn, double duration, double tremor)
      : random_(seed), length_(length), turn_(turn), duration_(duration), tremor_(tremor) {
    next();
  }
  PartState at(double t) {
    while (t - begin_ >= duration_) {
      begin_ += duration_;
      from_ = along(1.0);
      next();
    }
    const double s = (t - begin_) / duration_;
    PartState state;
    state.part = 7;
    state.epoch = 3;
    state.worldFromPart = along(s * s * s * (10.0 + s * (-15.0 + 6.0 * s)));
    const double rate = 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration_;
    state.twist = {way_ * rate, rotation_ * rate};
    const double w = 2.0 * 3.14159265358979 * 10.0;
    const glm::dvec3 shake(std::sin(w * t), std::sin(1.1 * w * t + 1.0), std::sin(0.9 * w * t + 2.0));
    const glm::dvec3 rates(w * std::cos(w * t), 1.1 * w * std::cos(1.1 * w * t + 1.0),
                           0.9 * w * std::cos(0.9 * w * t + 2.0));
    state.worldFromPart.position += tremor_ * shake;
    state.twist.linear += tremor_ * rates;
    return state;
  }

 private:
  Pose along(double share) const {
    return {from_.position + way_ * share,
            glm::normalize(fromRotationVector(rotation_ * share) * from_.orientation)};
  }
  glm::dvec3 direction() {
    glm::dvec3 v;
    do {
      v = random_.vector(1.0);
    } while (glm::length(v) < 0.1 || glm::length(v) > 1.0);
    return glm::normalize(v);
  }
  void next() {
    way_ = length_ * direction();
    const glm::dvec3 back = kDeltaFrame.centre - from_.position;
    if (glm::dot(way_, back) < 0.0) way_ = -way_;  // so that the motion stays near the middle
    rotation_ = turn_ * direction();
  }

  RandomMessages random_;
  double length_, turn_, duration_, tremor_, begin_ = 0.0;
  Pose from_{kDeltaFrame.centre, glm::dquat(1.0, 0.0, 0.0, 0.0)};
  glm::dvec3 way_, rotation_;
};

struct Sizes {
  double mean = 0.0, most = 0.0;  // bytes
};
/// Of states encoded against those of 48 and 52 ms ago by turns, themselves encoded against those of 48 ms
/// before, and those whole or (`chained`) against others. The two bits of the datagram that announce a
/// difference are included.
Sizes sizesOf(HandMotion motion, bool chained = true) {
  constexpr std::size_t kSteps = 12;  // of 4 ms
  constexpr Micros kBefore = 48 * kMillisecond;
  Sizes sizes;
  std::vector<PartCode> codes;
  for (int i = 0; i < 5000; ++i) codes.push_back(codeOf(motion.at(4e-3 * i)));
  std::vector<PartBaseline> encoded;
  for (std::size_t i = 0; i < codes.size(); ++i) {
    if (i < kSteps || !chained) {
      encoded.push_back({codes[i], false, {}, 0, {}});
    } else {
      const PartBaseline& against = encoded[i - kSteps];
      encoded.push_back(
          encodedAgainst(against, kBefore, codes[i], roundTrip(against, kBefore, codes[i]).orders));
    }
  }
  const std::size_t first = 3 * kSteps;
  for (std::size_t i = first; i < codes.size(); ++i) {
    const std::size_t age = kSteps + i % 2;
    const Micros elapsed = static_cast<Micros>(age) * 4 * kMillisecond;
    const double bytes = (2 + roundTrip(encoded[i - age], elapsed, codes[i]).bits) / 8.0;
    sizes.mean += bytes / static_cast<double>(codes.size() - first);
    sizes.most = std::max(sizes.most, bytes);
  }
  return sizes;
}

TEST(PartDelta, AMovingPartTakesAtMostTwelveBytesAgainstTheStateOf50MsAgo) {
  // Repeated strokes of 10 cm and 30 degrees in 0.8 s, by a hand with a tremor of 20 um.
  const HandMotion motion(1, 0.10, 0.52, 0.8, 2e-5);
  EXPECT_LE(sizesOf(motion).mean, 12.0);
  EXPECT_LE(sizesOf(motion).most, 15.5);
  // Strokes of 5 cm and 15 degrees in a second.
  EXPECT_LE(sizesOf(HandMotion(1, 0.05, 0.26, 1.0, 2e-5)).mean, 10.5);
  // As fast as in the test of the play-out: 0.5 m/s and 3 rad/s at the peak.
  EXPECT_LE(sizesOf(HandMotion(2, 0.2, 1.2, 0.75, 2e-5)).mean, 13.5);
  // Control: without a velocity from before the baseline it takes more.
  EXPECT_GT(sizesOf(motion, false).mean, 12.0);
}

TEST(PartDelta, AgainstAnotherBaselineSomethingElseComesOut) {
  HandMotion motion(3, 0.10, 0.52, 0.8, 2e-5);
  int wrong = 0;
  for (int i = 0; i < 200; ++i) {
    const PartBaseline right{codeOf(motion.at(0.02 * i)), false, {}, 0, {}};
    const PartBaseline other{codeOf(motion.at(0.02 * i + 0.004)), false, {}, 0, {}};
    const PartCode now = codeOf(motion.at(0.02 * i + 0.05));
    std::vector<std::byte> bytes(100);
    BitWriter writer(bytes);
    putDelta(writer, right, 50 * kMillisecond, now, kDeltaFrame);
    PartCode back = now;
    BitReader reader(bytes);
    getDelta(reader, other, 50 * kMillisecond, kDeltaFrame, back);
    wrong += !reader.failed() && !(back == now) ? 1 : 0;
  }
  EXPECT_GT(wrong, 150) << "a stream that did not check would show these";
}

TEST(PartDelta, WhateverTheBytesAreTheStateIsAValidOneOrNone) {
  RandomMessages random(22);
  int accepted = 0;
  for (int round = 0; round < 50000; ++round) {
    const auto parts = random.update(2, kDeltaFrame).parts;
    const PartBaseline baseline{codeOf(parts[0]),
                                random.chance(0.5),
                                codeOf(parts[1]).twist,
                                1 + random.number(1 << 22),
                                {3, 0, 15, 7}};
    std::vector<std::byte> bytes(random.number(40));
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.number(256));
    PartCode back = baseline.code;
    BitReader reader(bytes);
    getDelta(reader, baseline, 1 + random.number(kLongestElapsed), kDeltaFrame, back);
    if (reader.failed()) continue;
    ++accepted;
    PartState state;
    ASSERT_TRUE(fromCode(back, kDeltaFrame, state));
    ASSERT_TRUE(isValid(state.worldFromPart));
    ASSERT_LE(std::abs(state.twist.linear.x), kMaxLinearSpeed);
  }
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace tandem::sync
