#pragma once

// Section planes square to the world's axes, as the panel and --section set them: one that cuts away what
// lies beyond a position and one for what lies before it, on each axis. All six leave a box.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "assets/document/entry.h"

namespace tandem::client {

struct AxisSections {
  std::array<std::optional<double>, 3> beyond;  // m, world: what has a larger coordinate is cut away
  std::array<std::optional<double>, 3> before;  // m, world: what has a smaller one is

  bool any() const;
  std::vector<document::SectionPlane> planes() const;
  /// Adds "x=0.05" (beyond x = 0.05 m) or "-x=0.05" (before it), likewise y and z. The error says what is
  /// wrong with the text; nothing has changed then.
  Status add(const std::string& text);
};

}  // namespace tandem::client
