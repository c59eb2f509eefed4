#pragma once

// Reads a PNG back, so that tests can examine a viewer's picture.

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace tandem::client {

using Rgb = std::array<int, 3>;

struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // top row first

  /// {-1, -1, -1} outside the picture.
  Rgb at(int x, int y) const;
  /// How many pixels satisfy a condition.
  int count(const std::function<bool(const Rgb&)>& condition) const;
};

/// An empty picture if the file cannot be read.
Picture readPng(const std::string& path);

/// How many pixels of two pictures differ by more than `tolerance` in a channel; pixels that only one of them
/// has count as different.
int countDifferent(const Picture& a, const Picture& b, int tolerance);

}  // namespace tandem::client
