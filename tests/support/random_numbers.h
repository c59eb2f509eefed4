#pragma once

// Numbers drawn at random.

#include <random>

#include <glm/vec3.hpp>

namespace tandem::test {

/// A number that is drawn evenly from low to high.
template <typename Random>
double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Three such numbers from -1 to 1.
template <typename Random>
glm::dvec3 anyVector(Random& random) {
  const double x = between(random, -1.0, 1.0), y = between(random, -1.0, 1.0);
  return {x, y, between(random, -1.0, 1.0)};
}

}  // namespace tandem::test
