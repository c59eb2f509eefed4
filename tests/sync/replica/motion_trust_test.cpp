#include "sync/replica/motion_trust.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace tandem::sync {
namespace {

constexpr double kTick = 1e-3, kRadius = 0.1;

Pose at(double x, double angle = 0.0) {
  return {{x, 0.0, 0.0}, glm::angleAxis(angle, glm::dvec3(0.0, 0.0, 1.0))};
}

/// The tick in which the motion is suspect first, or -1.
template <typename Motion>
int suspectIn(const Motion& motion, double mass = 1.0, int ticks = 1000) {
  MotionTrust trust(mass, kRadius, motion(0.0));
  for (int i = 1; i <= ticks; ++i)
    if (trust.advance(motion(kTick * i), kTick)) return i;
  return -1;
}

TEST(MotionTrust, TrustsStrokesOfAHand) {
  for (const double hz : {0.5, 1.0, 2.0, 4.0})
    for (const double acceleration : {1.0, 10.0, 30.0}) {
      const double w = 2.0 * M_PI * hz;
      const double amplitude = std::min(acceleration, 2.5 * w) / (w * w);  // at up to 2.5 m/s
      EXPECT_EQ(suspectIn([&](double t) { return at(amplitude * std::cos(w * t)); }), -1) << hz;
      EXPECT_EQ(suspectIn([&](double t) { return at(0.0, amplitude / kRadius * std::cos(w * t)); }), -1);
    }
}

TEST(MotionTrust, TrustsAnyStopAndALightPartsStart) {
  EXPECT_EQ(suspectIn([](double t) { return at(t < 0.5 ? 4.0 * t * t : 1.0); }), -1) << "stops from 4 m/s";
  const auto start = [](double t) { return at(0.5 * 150.0 * std::min(t, 0.01) * std::min(t, 0.01)); };
  EXPECT_EQ(suspectIn(start, 0.05), -1);
  EXPECT_GT(suspectIn(start, 1.0), 0);
}

TEST(MotionTrust, SuspectsInTheFirstTicks) {
  EXPECT_EQ(suspectIn([](double t) { return at(t > 0.0 ? 2e-3 : 0.0); }), 1) << "a jump";
  EXPECT_EQ(suspectIn([](double t) { return at(t); }), 1) << "1 m/s at once";
  EXPECT_EQ(suspectIn([](double t) { return at(0.0, 20.0 * t); }), 1) << "spins at once";
  EXPECT_LE(suspectIn([](double t) { return at(0.02 * std::sin(2.0 * M_PI * 61.0 * t)); }), 1);
  EXPECT_LE(suspectIn([](double t) { return at(4e-3 * t * t * 1e3); }), 877) << "faster than 7 m/s";
}

TEST(MotionTrust, SuspectsForTwoSecondsAndForgets) {
  MotionTrust trust(1.0, kRadius, at(0.0));
  EXPECT_TRUE(trust.advance(at(0.1), kTick));
  int ticks = 0;
  while (trust.advance(at(0.1), kTick) && ticks < 5000) ++ticks;
  EXPECT_NEAR(kTick * ticks, MotionTrust::kSuspects, 2e-3);
}

/// Whether a motion is impossible at any time within 3 s.
template <typename Motion>
bool isImpossible(const Motion& motion) {
  MotionTrust trust(1.0, kRadius, motion(0.0));
  bool impossible = false;
  for (int i = 1; i <= 3000; ++i) {
    static_cast<void>(trust.advance(motion(kTick * i), kTick));
    impossible = impossible || trust.impossible();
  }
  return impossible;
}

TEST(MotionTrust, AccusesWhoGoesOnOnly) {
  EXPECT_TRUE(isImpossible([](double t) { return at(0.02 * std::sin(2.0 * M_PI * 61.0 * t)); }));
  EXPECT_TRUE(isImpossible([](double t) { return at(2e-3 * std::sin(2.0 * M_PI * 70.0 * t)); }));
  EXPECT_TRUE(isImpossible([](double t) { return at(std::fmod(t, 0.2) < 0.1 ? 0.0 : 0.05); }));
  EXPECT_FALSE(isImpossible([](double t) { return at(t < 0.5 ? 0.0 : 0.5); })) << "jumps once";
  EXPECT_FALSE(isImpossible([](double t) { return at(t < 0.5 ? 0.0 : std::min(0.3, 3.0 * (t - 0.5))); }));
  EXPECT_FALSE(isImpossible([](double t) { return at(0.03 * std::sin(2.0 * M_PI * 6.0 * t)); }));
}

TEST(MotionTrust, TrustsAMotionThatIsPlayedAtHalfItsSpeedNowAndThen) {
  for (const double every : {0.1, 0.17, 0.3}) {
    double x = 0.0, played = 0.0;
    EXPECT_EQ(suspectIn([&](double t) {
                // A play-out delay that grows by 5 ms.
                if (t > 0.0) played += std::fmod(t, every) < 0.01 ? 0.5 * kTick : kTick;
                x = 0.05 * (1.0 - std::cos(2.0 * M_PI * 1.5 * played));
                return at(x);
              }),
              -1)
        << every;
  }
}

TEST(MotionTrust, ExplainsAChangeOfOwnerByTheSpeedOfLate) {
  MotionTrust still(1.0, kRadius, at(0.0)), moved = still;
  still.jump(at(0.0), at(1e-3));
  EXPECT_TRUE(still.suspect());
  moved.remember(0.1);
  moved.jump(at(0.0), at(0.03));
  EXPECT_FALSE(moved.suspect());
}

}  // namespace
}  // namespace tandem::sync
