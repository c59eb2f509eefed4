#include "haptics/surface/contact_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tandem::haptics {
namespace {

constexpr double kDt = 1e-3, k = 500.0, k2 = 1500.0, tau = 0.05;

TEST(ContactLaw, ViscoelasticStepRelaxesWithItsTimeConstant) {
  ViscoelasticMemory memory;
  viscoelasticForce(k, k2, tau, 0.002, 1e-9, memory);  // a step
  for (int i = 1; i <= 200; ++i) {
    const double expected = 0.002 * (k + k2 * std::exp(-i * kDt / tau));
    EXPECT_NEAR(viscoelasticForce(k, k2, tau, 0.002, kDt, memory), expected, 1e-6) << i;
  }
}

TEST(ContactLaw, ViscoelasticRampIsExactAtEveryTickLength) {
  // q = k2 v tau (1 - exp(-t / tau)) for a ramp of speed v.
  for (const double dt : {1e-4, 1e-3, 1e-2}) {
    ViscoelasticMemory memory;
    const double v = 0.02;
    double force = 0.0;
    const int n = static_cast<int>(std::lround(0.1 / dt));
    for (int i = 1; i <= n; ++i) force = viscoelasticForce(k, k2, tau, v * i * dt, dt, memory);
    EXPECT_NEAR(force, k * v * 0.1 + k2 * v * tau * (1.0 - std::exp(-0.1 / tau)), 1e-9) << dt;
  }
}

/// Work of the contact on the tool over strokes in and out, J; negative = taken from the tool.
template <typename Law>
double strokeWork(const Law& law, double hertz) {
  double work = 0.0, before = 0.0, depth = 0.0;
  for (int i = 1; i <= 4000; ++i) {
    const double next = 0.001 - 0.002 * std::cos(2.0 * 3.14159265358979 * hertz * i * kDt);
    const double force = law(next);
    work -= 0.5 * (force + before) * (next - depth);
    before = force;
    depth = next;
  }
  return work;
}

TEST(ContactLaw, ViscoelasticContactOnlyTakesEnergyAndNeverPulls) {
  for (const double hertz : {0.5, 3.0, 20.0}) {
    ViscoelasticMemory memory;
    double least = 1.0;
    const double work = strokeWork(
        [&](double depth) {
          const double force = viscoelasticForce(k, k2, tau, depth, kDt, memory);
          least = std::min(least, force);
          return force;
        },
        hertz);
    EXPECT_LT(work, 0.0) << hertz;
    EXPECT_GE(least, 0.0);
  }
  // Negative control: a dashpot of the wrong sign gives energy, and the same account shows it.
  double last = -0.001;
  EXPECT_GT(strokeWork(
                [&last](double depth) {
                  const double force = depth > 0.0 ? k * depth - 5.0 * (depth - last) / kDt : 0.0;
                  last = depth;
                  return force;
                },
                3.0),
            0.0);
}

TEST(ContactLaw, WithoutRelaxationItIsASpring) {
  ViscoelasticMemory memory;
  EXPECT_DOUBLE_EQ(viscoelasticForce(k, 0.0, 0.0, 0.003, kDt, memory), k * 0.003);
  EXPECT_DOUBLE_EQ(viscoelasticForce(k, 0.0, 0.0, -0.003, kDt, memory), 0.0);
}

TEST(ContactLaw, PlasticYieldsHardensAndKeepsItsSet) {
  const double yield = 1.0, hardening = 250.0;
  double set = 0.0;
  EXPECT_DOUBLE_EQ(plasticForce(k, yield, hardening, 0.001, set), 0.5);
  EXPECT_EQ(set, 0.0) << "elastic below the yield force";
  // From 2 mm on (1 N) the slope is k H / (k + H).
  for (double depth = 0.002; depth < 0.01; depth += 0.0005)
    EXPECT_NEAR(plasticForce(k, yield, hardening, depth, set),
                1.0 + (depth - 0.002) * k * hardening / (k + hardening), 1e-12);
  const double left = set;
  EXPECT_GT(left, 0.0);
  EXPECT_EQ(plasticForce(k, yield, hardening, left, set), 0.0);
  EXPECT_NEAR(plasticForce(k, yield, hardening, left + 0.001, set), 0.5, 1e-12)
      << "elastic again, from the dent on";
  EXPECT_EQ(set, left);
}

TEST(ContactLaw, PlasticStrokesOnlyTakeEnergy) {
  double set = 0.0;
  const auto law = [&](double depth) { return plasticForce(k, 0.5, 100.0, depth, set); };
  const double first = strokeWork(law, 1.0);
  EXPECT_LT(first, -1e-4) << "the first strokes deform it";
  EXPECT_NEAR(strokeWork(law, 1.0), 0.0, 1e-6) << "later ones of the same depth are elastic";
}

}  // namespace
}  // namespace tandem::haptics
