#include "client/viewer/strip_chart.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "assets/base/assert.h"
#include "client/viewer/theme.h"

namespace tandem::client {
namespace {

struct Frame {
  ImVec2 min, max;
  float top;  // value at the upper edge
  float y(float value) const { return max.y - (max.y - min.y) * std::clamp(value / top, 0.0f, 1.0f); }
};

void drawGrid(ImDrawList& list, const Frame& frame, ImFont* small) {
  char text[16];
  for (const float share : {0.5f, 1.0f}) {
    const float y = frame.y(share * frame.top);
    if (share < 1.0f) list.AddLine({frame.min.x, y}, {frame.max.x, y}, theme::packed(theme::kLine));
    std::snprintf(text, sizeof text, "%g", static_cast<double>(share * frame.top));
    list.AddText(small, small->FontSize, {frame.min.x + 4, y + (share < 1.0f ? -small->FontSize - 1 : 1)},
                 theme::packed(theme::kMuted, 0.8f), text);
  }
}

void drawLimit(ImDrawList& list, const Frame& frame, const StripChart& chart, ImFont* small) {
  if (!(chart.limit > 0.0f) || chart.limit > frame.top) return;
  const float y = frame.y(chart.limit);
  for (float x = frame.min.x; x < frame.max.x; x += 8.0f)
    list.AddLine({x, y}, {std::min(x + 4.0f, frame.max.x), y}, theme::packed(theme::kBad, 0.7f));
  const ImVec2 size = small->CalcTextSizeA(small->FontSize, 1e9f, 0.0f, chart.limitLabel.c_str());
  list.AddText(small, small->FontSize, {frame.max.x - size.x - 4, y + 1}, theme::packed(theme::kBad, 0.8f),
               chart.limitLabel.c_str());
}

void drawValues(ImDrawList& list, const Frame& frame, const std::vector<float>& values,
                const ImVec4& colour) {
  if (values.size() < 2) return;
  const auto columns = static_cast<std::size_t>(std::max(frame.max.x - frame.min.x, 1.0f));
  float lastUpper = 0.0f, lastLower = 0.0f;
  for (std::size_t c = 0; c < columns; ++c) {
    const std::size_t first = c * values.size() / columns;
    const std::size_t last = std::max(first + 1, (c + 1) * values.size() / columns);
    const auto [low, high] = std::minmax_element(values.begin() + static_cast<std::ptrdiff_t>(first),
                                                 values.begin() + static_cast<std::ptrdiff_t>(last));
    const float x = frame.min.x + static_cast<float>(c);
    // Like an oscilloscope: each column spans its own values and reaches its neighbour's.
    float upper = frame.y(*high), lower = frame.y(*low);
    if (c > 0) {
      const float own = upper;
      upper = std::min(upper, lastLower);
      lower = std::max(lower, lastUpper);
      lastUpper = own;
      lastLower = frame.y(*low);
    } else {
      lastUpper = upper;
      lastLower = lower;
    }
    list.AddRectFilled({x, lower}, {x + 1.0f, frame.max.y}, theme::packed(colour, 0.10f));
    list.AddRectFilled({x, upper - 0.75f}, {x + 1.0f, lower + 0.75f}, theme::packed(colour));
  }
}

}  // namespace

float niceCeiling(float value) {
  if (!(value > 0.0f) || !std::isfinite(value)) return 1.0f;
  const float decade = std::pow(10.0f, std::floor(std::log10(value)));
  for (const float step : {1.0f, 1.5f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 8.0f})
    if (value <= step * decade * 1.0001f) return step * decade;
  return 10.0f * decade;
}

void drawStripChart(const StripChart& chart, const std::vector<float>& values, float height, ImFont* small) {
  ImGui::TextUnformatted(chart.title);
  const float valueWidth = ImGui::CalcTextSize(chart.now.c_str()).x;
  ImGui::SameLine(ImGui::GetContentRegionMax().x - valueWidth);
  ImGui::TextUnformatted(chart.now.c_str());
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const ImVec2 size(ImGui::GetContentRegionAvail().x, height);
  ImGui::InvisibleButton(chart.id, size);
  float top = chart.minimumRange;
  for (const float value : values) top = std::max(top, std::isfinite(value) ? value : 0.0f);
  ASSERT(top > 0.0f);
  const Frame frame{origin, {origin.x + size.x, origin.y + size.y}, niceCeiling(top)};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(frame.min, frame.max, theme::packed(theme::kRaised), 3.0f);
  list.PushClipRect(frame.min, frame.max, true);
  drawGrid(list, frame, small);
  drawValues(list, frame, values, chart.colour);
  drawLimit(list, frame, chart, small);
  list.PopClipRect();
  list.AddRect(frame.min, frame.max, theme::packed(theme::kLine), 3.0f);
}

}  // namespace tandem::client
