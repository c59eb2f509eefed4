#pragma once

// What the tests of part contact have in common.

#include <gtest/gtest.h>

#include <string>

#include "tests/support/full_size.h"
#include "tests/support/held_part_rig.h"

namespace tandem::test {

/// N, by which the force on a hand slower than 100 mm/s may change from one tick to the next: the largest
/// change and the 99th percentile of all changes.
inline constexpr double kMostChange = 0.25, kUsualChange = 0.05;

inline constexpr double kSteadyDepth = 5e-6;  // m, that parts may be in each other, led slowly
inline constexpr double kFastDepth = 20e-6;   // m, the same at 200 mm/s

/// All that must be true of any run.
inline void expectSound(const HeldPartRig& rig) {
  EXPECT_TRUE(rig.collides()) << rig.given().name;
  EXPECT_FALSE(rig.everFlagged(haptics::kFlagFault)) << rig.given().name;
  for (const RigTick& t : rig.ticks()) {
    ASSERT_TRUE(std::isfinite(glm::length(t.toHand.force) + glm::length(t.toHand.torque))) << t.time;
    ASSERT_TRUE(isValid(t.part)) << t.time;
  }
}

/// A line of figures for whoever runs the full size.
inline void report(const HeldPartRig& rig) {
  if (!atFullSize()) return;
  const std::vector<double> cpu = rig.cpuTimes(), steps = rig.forceSteps();
  std::printf(
      "%-32s z %8.3f of %8.3f mm, depth %6.2f um, force %6.2f N, step p99 %6.4f max %6.4f N, energy %8.5f J, "
      "us p50 %4.0f p99 %4.0f max %5.0f\n",
      rig.given().name.c_str(), 1e3 * rig.last().part.position.z, 1e3 * rig.last().device.position.z,
      1e6 * rig.deepest(), rig.mostForce(), quantile(steps, 0.99), quantile(steps, 1.0), rig.energyGiven(),
      1e6 * quantile(cpu, 0.5), 1e6 * quantile(cpu, 0.99), 1e6 * quantile(cpu, 1.0));
}

}  // namespace tandem::test
