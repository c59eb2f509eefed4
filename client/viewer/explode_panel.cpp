// The panel that draws parts apart, and the line that says so over the scene.

#include <imgui.h>

#include <algorithm>
#include <string>

#include "client/viewer/panels.h"

namespace tandem::client {

void drawExplode(const PanelContext& context) {
  const bool followed = context.ui.shared.following().followsView();
  ImGui::BeginDisabled(followed);
  document::PartStyle& style = context.ui.parts.style;
  auto percent = static_cast<float>(100.0 * style.explode);
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(theme::kMuted, "Apart");
  ImGui::SameLine(108.0f * context.scale);
  if (numberSlider(context, "##apart", percent, {0.0f, 100.0f, "%.0f %%", 0}))
    style.explode = 0.01 * static_cast<double>(percent);
  if (!style.apart.empty()) {
    ImGui::TextColored(theme::kMuted, "%s",
                       (std::to_string(style.apart.size()) + " parts of a group").c_str());
    ImGui::SameLine();
    if (ImGui::SmallButton("All parts")) style.apart.clear();
  }
  ImGui::EndDisabled();
}

void drawApart(const PanelContext& context, const Rect& viewport) {
  if (!(context.ui.parts.style.explode > 0.0)) return;
  const double above = context.model.replay ? 64.0 * static_cast<double>(context.scale) : 14.0;
  ImGui::SetNextWindowPos({static_cast<float>(0.5 * (viewport.min.x + viewport.max.x)),
                           static_cast<float>(viewport.max.y - above)},
                          ImGuiCond_Always, {0.5f, 1.0f});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 5.0f);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, theme::kRaised);
  ImGui::Begin("##apart line", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoInputs);
  ImGui::TextColored(theme::kMuted, "%s",
                     context.model.replay ? "Exploded: parts are shown apart"
                                          : "Exploded: parts are shown apart, nothing is felt");
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
}

}  // namespace tandem::client
