#include "sync/replica/motion_judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace tandem::sync {
namespace {

/// A part whose states come every 4 ms, as its owner claims them.
struct Claims {
  MotionJudge judge{{0.05, 1.0, 5.0}};
  PartState state;
  Micros now = 0;
  int calls = 0;

  Claims() { state.part = 0; }
  void add(const glm::dvec3& position, const glm::dvec3& velocity, Micros elapsed = 4 * kMillisecond) {
    now += elapsed;
    ++state.sequence;
    state.worldFromPart.position = position;
    state.twist.linear = velocity;
    calls += judge.judge(state, now, now + 25 * kMillisecond) ? 1 : 0;
  }
};

TEST(MotionJudge, FindsNothingInTheFastestMotionsOfAHand) {
  for (const PartId part : {PartId{0}, PartId{1}, PartId{2}})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      std::mt19937_64 dice(seed);
      std::uniform_real_distribution<> share;
      Claims claims;
      claims.state.part = part;
      claims.state.epoch = 1;
      // Strokes of up to 2 m/s, each ended by a stop in no time, as at a wall; one state in ten is lost.
      double x = 0.0, t = 0.0, speed = 0.0, way = 0.0;
      for (int i = 0; i < 5000; ++i) {
        t += 4e-3;
        const double before = speed;
        speed = std::min(speed + 50.0 * 4e-3, way);
        x += 0.5 * (before + speed) * 4e-3;
        if (share(dice) < 0.02) speed = 0.0, way = 2.0 * share(dice);
        if (share(dice) < 0.9)
          claims.add({x, 0.0, 0.0}, {speed, 0.0, 0.0}, static_cast<Micros>(t * 1e6) - claims.now);
      }
      EXPECT_EQ(claims.calls, 0);
      EXPECT_EQ(claims.judge.impossible(), 0u) << part << " " << seed;
    }
}

TEST(MotionJudge, CallsOutWhatNoHandCanDo) {
  const auto isCalled = [](const auto& motion) {
    Claims claims;
    claims.state.part = 1;
    claims.state.epoch = 1;
    for (int i = 0; i < 500; ++i) motion(claims, 4e-3 * i);
    return claims.calls == 1;
  };
  EXPECT_TRUE(isCalled([](Claims& c, double t) {  // +-20 mm at 61 Hz
    const double w = 2.0 * M_PI * 61.0;
    c.add({0.02 * std::sin(w * t), 0.0, 0.0}, {0.02 * w * std::cos(w * t), 0.0, 0.0});
  }));
  EXPECT_TRUE(isCalled([](Claims& c, double t) {  // jumps
    c.add({std::fmod(t, 0.04) < 0.02 ? 0.5 : 0.0, 0.0, 0.0}, {});
  }));
  EXPECT_TRUE(isCalled([](Claims& c, double t) {  // a shake that claims to rest
    c.add({0.02 * std::sin(100.0 * t), 0.0, 0.0}, {});
  }));
  EXPECT_TRUE(isCalled([](Claims& c, double) { c.add({}, {3.0, 0.0, 0.0}); })) << "fast, and stands still";
  EXPECT_TRUE(isCalled([](Claims& c, double t) {  // time runs back
    c.add({}, {}, std::fmod(t, 0.2) < 0.004 ? 200 * kMillisecond : -30 * kMillisecond);
  }));
  EXPECT_TRUE(isCalled([](Claims& c, double) {
    c.state.twist.angular = {0.0, 0.0, 64.0 + 40.0};
    c.add({}, {});
  }));
}

TEST(MotionJudge, ForgivesWhatHappensOnce) {
  Claims claims;
  claims.state.epoch = 1;
  for (int second = 0; second < 60; ++second) {
    claims.add({0.3 * second, 0.0, 0.0}, {});
    for (int i = 0; i < 249; ++i) claims.add({0.3 * second, 0.0, 0.0}, {});
  }
  EXPECT_GE(claims.judge.impossible(), 50u);
  EXPECT_EQ(claims.calls, 0);
}

TEST(MotionJudge, CallsALiarOnceInTenSeconds) {
  Claims claims;
  claims.state.epoch = 1;
  for (int i = 0; i < 250 * 31; ++i) claims.add({i % 2 == 0 ? 0.5 : 0.0, 0.0, 0.0}, {});
  EXPECT_EQ(claims.calls, 4);
}

TEST(MotionJudge, ANewEpochBeginsAnew) {
  Claims claims;
  for (int i = 0; i < 1000; ++i) {
    ++claims.state.epoch;
    claims.add({i % 2 == 0 ? 0.5 : 0.0, 0.0, 0.0}, {});
  }
  EXPECT_EQ(claims.judge.impossible(), 0u);
}

}  // namespace
}  // namespace tandem::sync
