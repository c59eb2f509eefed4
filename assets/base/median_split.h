#pragma once

// How the trees over points and triangles divide: at the median along the longest side of a box.

#include <algorithm>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace tandem {

/// Sorts order[begin..end) about its middle along the longest axis of `extent`, and returns that middle. The
/// place of an index is at(index); the lower of two indices in one place comes first, on every library.
template <typename At>
std::uint32_t splitAtMedian(std::vector<std::uint32_t>& order, std::uint32_t begin, std::uint32_t end,
                            const glm::dvec3& extent, const At& at) {
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                   [&](std::uint32_t i, std::uint32_t j) {
                     const double x = at(i)[axis], y = at(j)[axis];
                     return x != y ? x < y : i < j;
                   });
  return middle;
}

}  // namespace tandem
