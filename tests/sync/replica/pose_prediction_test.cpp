// The display pose of a part that another site moves.

#include "sync/replica/pose_prediction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

namespace tandem::sync {
namespace {

constexpr Micros kTransit = 100 * kMillisecond;

struct Drawn {
  double rms = 0.0, largestStep = 0.0;  // m
};

/// A part whose states are sent every 10 ms and arrive after kTransit. From 0.5 s on it is drawn each ms and
/// compared with its true pose. `predicts`: false draws the newest state as it arrived.
Drawn follow(const std::function<double(double)>& place, bool predicts, double seconds) {
  PosePrediction prediction;
  prediction.restart({{place(0.0), 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, 0);
  PartState newest;
  newest.worldFromPart.position.x = place(0.0);
  Drawn drawn;
  double squares = 0.0, before = place(0.0);
  int count = 0;
  for (Micros now = 0; now < static_cast<Micros>(seconds * 1e6); now += kMillisecond) {
    if (now % (10 * kMillisecond) == 0 && now >= kTransit) {
      const double t = toSeconds(now - kTransit), h = 1e-5;
      PartState state;
      state.worldFromPart.position.x = place(t);
      state.twist.linear.x = (place(t + h) - place(t - h)) / (2.0 * h);
      prediction.push(state, now - kTransit);
      newest = state;
    }
    const Pose pose = predicts ? prediction.at(now) : newest.worldFromPart;
    const double x = pose.position.x;
    drawn.largestStep = std::max(drawn.largestStep, std::abs(x - before));
    before = x;
    if (now < 500 * kMillisecond) continue;
    const double error = x - place(toSeconds(now));
    squares += error * error;
    ++count;
  }
  drawn.rms = std::sqrt(squares / count);
  return drawn;
}

double swing(double t) { return 0.025 * std::sin(2.0 * 3.14159265358979 * 0.5 * t); }

TEST(PosePrediction, ShowsASwingWhereItIsByNow) {
  EXPECT_LT(follow(swing, true, 6.0).rms, 0.6e-3);
  EXPECT_GT(follow(swing, false, 6.0).rms, 4e-3) << "without it";
}

TEST(PosePrediction, CorrectsWithoutAJumpWherePartsStop) {
  const auto stops = [](double t) { return t < 1.0 ? 0.1 * t : 0.1; };
  const Drawn drawn = follow(stops, true, 2.0);
  EXPECT_LT(drawn.largestStep, 1.2e-3);  // 11 mm too far, corrected within some 20 ms
  PosePrediction prediction;
  prediction.restart({}, 0);
  PartState state;
  state.twist.linear.x = 0.1;
  prediction.push(state, 0);
  prediction.at(kTransit);
  EXPECT_LT(prediction.at(10 * kSecond).position.x, 0.1 * (toSeconds(kTransit) + 0.07)) << "nothing arrives";
}

TEST(PosePrediction, WhatBrakesDoesNotTurnBack) {
  PosePrediction prediction;
  prediction.restart({}, 0);
  double furthest = 0.0;
  for (int i = 0; i <= 30; ++i) {  // 0.3 m/s, braking at 1 m/s^2
    PartState state;
    const double t = 0.01 * i;
    state.worldFromPart.position.x = 0.3 * t - 0.5 * t * t;
    state.twist.linear.x = 0.3 - t;
    prediction.push(state, static_cast<Micros>(1e6 * t));
    const double x = prediction.at(static_cast<Micros>(1e6 * t) + kTransit).position.x;
    EXPECT_GT(x, furthest - 1e-3);
    furthest = std::max(furthest, x);
  }
  EXPECT_NEAR(furthest, 0.045, 2e-3);
}

TEST(PosePrediction, StandsWhereItIsPutThoughALaterStateIsKnown) {
  const Pose rest{{0.1, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  const auto drawn = [&](bool stands) {
    PosePrediction prediction;
    prediction.restart({}, 0);
    PartState ahead;
    ahead.twist.linear.x = 1.0;
    prediction.push(ahead, 2 * kMillisecond);
    PartState resting;
    resting.worldFromPart = rest;
    if (stands)
      prediction.standAt(rest, kMillisecond);
    else
      prediction.push(resting, kMillisecond);
    Pose pose;
    for (Micros now = kMillisecond; now < kSecond; now += kMillisecond) pose = prediction.at(now);
    return pose;
  };
  EXPECT_TRUE(PosePrediction::near(drawn(true), rest));
  EXPECT_FALSE(PosePrediction::near(drawn(false), rest));
}

TEST(PosePrediction, OlderStatesChangeNothing) {
  PosePrediction prediction;
  PartState state;
  state.worldFromPart.position.x = 0.2;
  prediction.push(state, 20);
  const Pose now = prediction.at(30);
  state.worldFromPart.position.x = 0.1;
  prediction.push(state, 10);
  EXPECT_EQ(prediction.at(31).position, now.position);
}

}  // namespace
}  // namespace tandem::sync
