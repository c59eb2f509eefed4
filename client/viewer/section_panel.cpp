// The panel of section planes: a line for each side of each axis, with a switch and a place.

#include <imgui.h>

#include "client/viewer/panels.h"
#include "client/viewer/theme.h"

namespace tandem::client {
namespace {

/// One plane: off, or at a place between `least` and `most`, m.
void drawPlane(const PanelContext& context, const char* name, const char* id, double least, double most,
               std::optional<double>& place) {
  bool on = place.has_value();
  if (ImGui::Checkbox(name, &on)) {
    if (on)
      place = 0.5 * (least + most);
    else
      place.reset();
  }
  if (!place) return;
  ImGui::SameLine(108.0f * context.scale);
  auto millimetres = static_cast<float>(1e3 * *place);
  const SliderRange range{static_cast<float>(1e3 * least), static_cast<float>(1e3 * most), "%.2f mm", 0};
  if (numberSlider(context, id, millimetres, range)) place = 1e-3 * static_cast<double>(millimetres);
}

}  // namespace

void drawSections(const PanelContext& context) {
  const assets::Bounds& bounds = context.model.scene->bounds;
  static constexpr const char* kBeyond[] = {"Beyond x", "Beyond y", "Beyond z"};
  static constexpr const char* kBefore[] = {"Before x", "Before y", "Before z"};
  static constexpr const char* kIds[] = {"##beyond x", "##beyond y", "##beyond z",
                                         "##before x", "##before y", "##before z"};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    AxisSections& sections = context.ui.sections;
    drawPlane(context, kBeyond[i], kIds[i], bounds.min[axis], bounds.max[axis], sections.beyond[i]);
    drawPlane(context, kBefore[i], kIds[i + 3], bounds.min[axis], bounds.max[axis], sections.before[i]);
  }
  ImGui::TextColored(theme::kMuted, "Cut away to see; it is still felt.");
  if (context.ui.sections.any() && ImGui::SmallButton("All off")) context.ui.sections = {};
}

}  // namespace tandem::client
