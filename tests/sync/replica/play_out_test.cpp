#include "sync/replica/play_out.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <queue>

#include "tests/sync/wire/random_messages.h"

namespace tandem::sync {
namespace {

const glm::dvec3 kAxis = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));

/// There and back by minimum-jerk strokes of 0.2 m whose top speed is 0.5 m/s, turning 1.2 rad meanwhile.
PartState owner(Micros at) {
  constexpr double kTravel = 0.2, kDuration = 0.75, kTurn = 1.2;  // top speed 1.875 travel / duration
  const double t = std::max(0.0, toSeconds(at));
  const double phase = std::fmod(t, 2.0 * kDuration);
  const double s = phase < kDuration ? phase / kDuration : 2.0 - phase / kDuration;
  const double direction = phase < kDuration ? 1.0 : -1.0;
  const double x = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
  const double rate = direction * 30.0 * s * s * (1.0 - s) * (1.0 - s) / kDuration;
  PartState state;
  state.worldFromPart.position = glm::dvec3(kTravel * x, 0.0, 0.05 * x);
  state.worldFromPart.orientation = fromRotationVector(kAxis * (kTurn * x));
  state.twist.linear = glm::dvec3(kTravel * rate, 0.0, 0.05 * rate);
  state.twist.angular = kAxis * (kTurn * rate);
  return state;
}

struct Path {
  double oneWay_s = 0.025, jitter = 0.2, loss = 0.02;
  Micros silentFrom = -1, silentUntil = -1;
};
struct Figures {
  double worst = 0.0, worstAngle = 0.0, worstStep = 0.0, sumSquares = 0.0;
  int samples = 0;
};

/// Streams owner() at 250 Hz over `path`, plays it out at 1 kHz.
Figures stream(const Path& path, std::uint64_t seed, bool interpolating = true) {
  struct Packet {
    Micros arrival, time;
    bool operator<(const Packet& other) const { return arrival > other.arrival; }
  };
  testing::RandomMessages random(seed);
  const WireFrame frame{{0.0, 0.0, 0.0}, 2.0};
  std::priority_queue<Packet> flying;
  PlayOut play;
  PlayOutDelay delay;
  play.restart(owner(0).worldFromPart, 0, 0);
  Figures figures;
  glm::dvec3 last(0.0);
  for (Micros now = 0; now < 10 * kSecond; now += kMillisecond) {
    const bool silent = now >= path.silentFrom && now < path.silentUntil;
    if (now % (4 * kMillisecond) == 0 && !random.chance(path.loss) && !silent) {
      const double transit = path.oneWay_s * (1.0 + path.jitter * random.real(-1.0, 1.0));
      flying.push({now + static_cast<Micros>(transit * 1e6), now});
    }
    while (!flying.empty() && flying.top().arrival <= now) {
      const Packet packet = flying.top();
      flying.pop();
      PartState state = quantised(owner(packet.time), frame);
      if (!interpolating) state.twist = {};
      play.push(state, packet.time);
      delay.observe(packet.time, packet.arrival);
    }
    const Micros late = delay.delay(now);
    const Pose shown = play.at(now, late).worldFromPart;
    if (now > kSecond) {
      const Pose truth = owner(now - late).worldFromPart;
      const double error = glm::length(shown.position - truth.position);
      figures.worst = std::max(figures.worst, error);
      figures.sumSquares += error * error;
      ++figures.samples;
      figures.worstAngle =
          std::max(figures.worstAngle,
                   glm::length(rotationVector(shown.orientation * glm::conjugate(truth.orientation))));
      figures.worstStep = std::max(figures.worstStep, glm::length(shown.position - last));
    }
    last = shown.position;
  }
  return figures;
}

TEST(PlayOut, ShowsTheOwnersPathWithinAMillimetreOverJitterAndLoss) {
  Figures worst;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Figures f = stream({}, seed);
    worst.worst = std::max(worst.worst, f.worst);
    worst.worstAngle = std::max(worst.worstAngle, f.worstAngle);
    worst.worstStep = std::max(worst.worstStep, f.worstStep);
    worst.sumSquares += f.sumSquares;
    worst.samples += f.samples;
  }
  RecordProperty("worst_um", static_cast<int>(worst.worst * 1e6));
  RecordProperty("rms_um", static_cast<int>(1e6 * std::sqrt(worst.sumSquares / worst.samples)));
  RecordProperty("worst_angle_urad", static_cast<int>(worst.worstAngle * 1e6));
  std::printf("play-out: worst %.1f um, rms %.2f um, worst angle %.0f urad, worst step %.0f um/ms\n",
              worst.worst * 1e6, 1e6 * std::sqrt(worst.sumSquares / worst.samples), worst.worstAngle * 1e6,
              worst.worstStep * 1e6);
  EXPECT_LT(worst.worst, 1e-3);
  EXPECT_LT(worst.worstAngle, 5e-3);
  EXPECT_LT(worst.worstStep, 1.1 * 0.52e-3) << "never faster than the owner by more than a tenth";
}

TEST(PlayOut, WithoutVelocitiesTheSameStreamIsWorse) {
  EXPECT_GT(stream({}, 3, false).worst, 4.0 * stream({}, 3).worst);
}

TEST(PlayOut, ComesBackFromASilenceWithoutAStep) {
  for (const Micros length : {60, 120, 250, 500, 1000}) {
    Path path;
    path.silentFrom = 3050 * kMillisecond;
    path.silentUntil = path.silentFrom + length * kMillisecond;
    // The bound adds 0.52 m/s of the owner, 1 m/s of the correction, and the share of the slowed play-out.
    EXPECT_LT(stream(path, 9).worstStep, 1.7e-3) << length << " ms";
  }
}

PartState stillAt(double x) {
  PartState state;
  state.worldFromPart.position.x = x;
  return state;
}

TEST(PlayOut, EndsExactlyAtThePoseOfAPartAtRest) {
  PlayOut play;
  play.restart({}, 0, 0);
  PartState moving = stillAt(0.01);
  moving.twist.linear.x = 0.5;
  play.push(moving, 10 * kMillisecond);
  play.at(50 * kMillisecond, 5 * kMillisecond);  // extrapolated beyond
  const PartState rest = stillAt(0.0123);
  play.push(rest, 14 * kMillisecond);
  PlayOut::Shown shown;
  for (Micros now = 51; now < 600; ++now) shown = play.at(now * kMillisecond, 5 * kMillisecond);
  EXPECT_EQ(shown.worldFromPart.position, rest.worldFromPart.position);
  EXPECT_EQ(shown.worldFromPart.orientation, rest.worldFromPart.orientation);
  EXPECT_TRUE(shown.still);
  EXPECT_FALSE(shown.extrapolated);
  EXPECT_EQ(shown.twist.linear, glm::dvec3(0.0));
}

TEST(PlayOut, ExtrapolatesForABoundedTimeThenStands) {
  PlayOut play;
  play.restart({}, 0, 0);
  PartState moving = stillAt(0.0);
  moving.twist.linear.x = 1.0;
  play.push(moving, 0);
  EXPECT_NEAR(play.at(10 * kMillisecond, 0).worldFromPart.position.x, 0.010, 1e-12);
  EXPECT_TRUE(play.at(20 * kMillisecond, 0).extrapolated);
  const double end = play.at(50 * kMillisecond, 0).worldFromPart.position.x;
  EXPECT_LE(end, 0.050);
  const auto later = play.at(kSecond, 0);
  EXPECT_EQ(later.worldFromPart.position.x, end);
  EXPECT_EQ(later.twist.linear.x, 0.0);
  EXPECT_TRUE(later.still);
}

TEST(PlayOut, SortsInWhatArrivesOutOfOrder) {
  PlayOut inOrder, shuffled;
  for (PlayOut* play : {&inOrder, &shuffled}) play->restart(owner(0).worldFromPart, 0, 0);
  for (const int i : {1, 2, 3, 4, 5}) inOrder.push(owner(i * 4000), i * 4000);
  for (const int i : {4, 1, 5, 3, 3, 2}) shuffled.push(owner(i * 4000), i * 4000);
  for (Micros t = 0; t < 20000; t += 500) {
    EXPECT_EQ(inOrder.at(t, 0).worldFromPart.position, shuffled.at(t, 0).worldFromPart.position);
  }
}

TEST(PlayOut, ARestartBlendsFromWhatWasShown) {
  PlayOut play;
  play.restart(stillAt(0.0).worldFromPart, 0, 0);
  play.at(0, 0);
  play.restart(stillAt(0.1).worldFromPart, 0, 300 * kMillisecond);
  double last = 0.0;
  for (Micros now = 1; now <= 300; ++now) {
    const double x = play.at(now * kMillisecond, 0).worldFromPart.position.x;
    EXPECT_GE(x, last - 1e-12);
    EXPECT_LE(x - last, 2e-3);
    last = x;
  }
  EXPECT_NEAR(last, 0.1, 2e-5);
  EXPECT_EQ(play.at(310 * kMillisecond, 0).worldFromPart.position.x, 0.1) << "and ends there exactly";
  play.restart(stillAt(0.5).worldFromPart, 0, 0);
  EXPECT_EQ(play.at(320 * kMillisecond, 0).worldFromPart.position.x, 0.5) << "at once if asked";
}

TEST(PlayOut, KeepsTheNewestWhenItIsFull) {
  PlayOut play;
  play.restart({}, 0, 0);
  for (int i = 0; i < 1000; ++i) play.push(stillAt(i), i * 4000);
  EXPECT_EQ(play.at(999 * 4000, 0).worldFromPart.position.x, 999.0);
  play.push(stillAt(-1), 4000);  // older than everything kept
  EXPECT_EQ(play.at(999 * 4000, 0).worldFromPart.position.x, 999.0);
}

TEST(PlayOutDelay, CoversTheDelaysAndNeverRunsBackwards) {
  testing::RandomMessages random(4);
  PlayOutDelay delay;
  EXPECT_EQ(delay.delay(0), 0);
  Micros lastPlay = -kSecond;
  for (Micros now = 0; now < 20 * kSecond; now += 4 * kMillisecond) {
    const double mean = now > 5 * kSecond && now < 10 * kSecond ? 250e3 : 25e3;
    const auto transit = static_cast<Micros>(mean * random.real(0.8, 1.2));
    delay.observe(now - transit, now);
    const Micros play = now - delay.delay(now);
    EXPECT_GE(play, lastPlay);
    lastPlay = play;
    if (now > 2 * kSecond && now < 5 * kSecond) {
      EXPECT_NEAR(static_cast<double>(delay.delay(now)), 31.8e3, 1.2e3);
    }
    if (now > 7 * kSecond && now < 10 * kSecond) {
      EXPECT_NEAR(static_cast<double>(delay.delay(now)), 299e3, 9e3);
    }
  }
  EXPECT_NEAR(static_cast<double>(delay.delay(20 * kSecond)), 31.8e3, 1.2e3) << "and comes down again";
}

}  // namespace
}  // namespace tandem::sync
