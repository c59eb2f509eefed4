#pragma once

// Numbers drawn at random.

#include <random>

namespace tandem::test {

/// A number that is drawn evenly from low to high.
template <typename Random>
double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

}  // namespace tandem::test
