#pragma once

// Random goals and rows for the tests of the contact solver and its parts.

#include <cmath>
#include <cstdint>
#include <random>

#include <glm/geometric.hpp>

#include "haptics/solver/step_space.h"

namespace tandem::test {

class Numbers {
 public:
  explicit Numbers(unsigned seed) : random_(seed) {}
  double operator()() { return spread_(random_); }
  glm::dvec3 vector() { return {(*this)(), (*this)(), (*this)()}; }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> spread_{-1.0, 1.0};
};

/// Something like a part of 0.1 kg and 2 cm on a coupling.
inline haptics::StepGoal randomGoal(Numbers& number) {
  haptics::StepGoal goal;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t k = 0; k < i; ++k) goal.root[i][k] = 0.02 * number() * (i < 3 ? 1.0 : 0.02);
    goal.root[i][i] = (0.3 + 0.05 * number()) * (i < 3 ? 1.0 : 0.02);
  }
  goal.free = {1e-4 * number.vector(), 5e-3 * number.vector()};
  return goal;
}

inline haptics::ExactRow randomRow(Numbers& number, std::uint32_t sample) {
  haptics::ExactRow row;
  row.normal = glm::normalize(number.vector());
  row.arm = 0.02 * number.vector();
  row.gap = 2e-5 * std::abs(number());
  row.source.sample = sample;
  return row;
}

}  // namespace tandem::test
