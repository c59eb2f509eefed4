#include "haptics/overlap/peak_of_least.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

double leastAt(std::span<const glm::dvec3> functions, const glm::dvec3& shares) {
  double least = glm::dot(functions[0], shares);
  for (const glm::dvec3& f : functions.subspan(1)) least = std::min(least, glm::dot(f, shares));
  return least;
}

/// Where two functions are equal on each side of the triangle.
void tryPair(std::span<const glm::dvec3> functions, const glm::dvec3& difference, Peak& best) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if ((difference[i] > 0.0) == (difference[j] > 0.0)) continue;
    glm::dvec3 shares(0.0);
    shares[j] = difference[i] / (difference[i] - difference[j]);
    shares[i] = 1.0 - shares[j];
    const double value = leastAt(functions, shares);
    if (value > best.value) best = {value, shares};
  }
}

/// Where three functions are equal: the shares are orthogonal to two differences.
void tryTriple(std::span<const glm::dvec3> functions, const glm::dvec3& first, const glm::dvec3& second,
               Peak& best) {
  const glm::dvec3 across = glm::cross(first, second);
  const double sum = across.x + across.y + across.z;
  if (sum == 0.0) return;
  const glm::dvec3 shares = across / sum;
  if (!(std::min({shares.x, shares.y, shares.z}) >= 0.0)) return;
  const double value = leastAt(functions, shares);
  if (value > best.value) best = {value, shares};
}

}  // namespace

Peak peakOfLeast(std::span<const glm::dvec3> functions) {
  ASSERT(!functions.empty() && functions.size() <= kMaxFunctions);
  Peak best;
  best.value = leastAt(functions, best.shares);
  for (const glm::dvec3& corner : {glm::dvec3(0.0, 1.0, 0.0), glm::dvec3(0.0, 0.0, 1.0)}) {
    const double value = leastAt(functions, corner);
    if (value > best.value) best = {value, corner};
  }
  for (std::size_t i = 0; i < functions.size(); ++i) {
    for (std::size_t j = i + 1; j < functions.size(); ++j) {
      const glm::dvec3 difference = functions[i] - functions[j];
      tryPair(functions, difference, best);
      for (std::size_t k = j + 1; k < functions.size(); ++k)
        tryTriple(functions, difference, functions[i] - functions[k], best);
    }
  }
  return best;
}

}  // namespace tandem::haptics
