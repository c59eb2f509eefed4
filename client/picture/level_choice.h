#pragma once

// Which level of a mesh is drawn, by how far off it is on the screen. Pure.

#include <cstddef>
#include <span>

namespace tandem::client {

inline constexpr double kMostPixels = 1.0;      // by which a level may be off that is drawn
inline constexpr double kCoarserPixels = 0.75;  // below which a coarser one than the last is taken

/// The index of the coarsest level whose error is at most kMostPixels on the screen, or 0 if there is none.
/// `errors` are in m, the finest level first; `pixel` is the width in m that a pixel covers at the part.
/// `last` is the level that was drawn before, or the number of levels if none was: a coarser one has to be
/// within kCoarserPixels, so that a moving part does not change between two levels at every frame.
inline std::size_t chooseLevel(std::span<const double> errors, double pixel, std::size_t last) {
  for (std::size_t i = errors.size(); i-- > 1;) {
    const bool coarser = last < errors.size() && i > last;
    if (errors[i] <= (coarser ? kCoarserPixels : kMostPixels) * pixel) return i;
  }
  return 0;
}

}  // namespace tandem::client
