#pragma once

// Which level of a mesh is drawn, by how far off it is on the screen. Pure.

#include <cstddef>
#include <span>

namespace tandem::client {

inline constexpr double kMostPixels = 1.0;      // by which a level may be off that is drawn
inline constexpr double kCoarserPixels = 0.75;  // below which a coarser one than the last is taken

/// Of levels by their errors (m, the finest first) the coarsest that is off by no more than kMostPixels where
/// a pixel is `pixel` m; the finest if none is. `last` is what was drawn before, or the number of levels:
/// nothing coarser than it is taken before that is off by less than kCoarserPixels, so that a moving part
/// does not go to and fro.
inline std::size_t chooseLevel(std::span<const double> errors, double pixel, std::size_t last) {
  for (std::size_t i = errors.size(); i-- > 1;) {
    const bool coarser = last < errors.size() && i > last;
    if (errors[i] <= (coarser ? kCoarserPixels : kMostPixels) * pixel) return i;
  }
  return 0;
}

}  // namespace tandem::client
