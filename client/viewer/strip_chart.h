#pragma once

#include <imgui.h>

#include <string>
#include <vector>

namespace tandem::client {

/// A plot of recent values against time, newest at the right, with a limit line. Min and max of each pixel
/// column are drawn, so that a single late tick among thousands is visible.
struct StripChart {
  const char* id = "";
  const char* title = "";
  std::string now;     // the latest value in words
  float limit = 0.0f;  // of the dashed line; none if not positive
  std::string limitLabel;
  float minimumRange = 1.0f;  // the axis reaches at least to here
  ImVec4 colour{0.0f, 0.0f, 0.0f, 1.0f};
};

void drawStripChart(const StripChart& chart, const std::vector<float>& values, float height, ImFont* small);

/// The smallest of 1, 1.5, 2, 3, 4, 5, 6 or 8 times a power of ten that is not below `value`; 1 for nonsense.
float niceCeiling(float value);

}  // namespace tandem::client
