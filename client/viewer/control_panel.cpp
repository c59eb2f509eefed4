#include <imgui.h>

#include <cstdio>
#include <string>

#include "client/viewer/panels.h"

namespace tandem::client {
namespace {

constexpr double kDegrees = 57.29577951308232;

/// Shown in degrees or millimetres: what a person reads off a dial and a slider.
double shownPerUnit(const assets::Control& control) { return assets::turns(control) ? kDegrees : 1e3; }

/// Why the person may not set a control now; empty if nothing forbids it.
std::string obstacle(const ViewModel& model, const assets::Control& control) {
  if (model.replay) return "a replay";
  if ((control.roles >> static_cast<unsigned>(model.role) & 1u) == 0) return "your role may not set it";
  const SiteId owner = control.part < model.owner.size() ? model.owner[control.part] : kNoSite;
  if (owner == kNoSite) return {};
  for (const SiteView& site : model.sites)
    if (site.info.site == owner) return site.self ? std::string() : site.info.name + " holds it";
  return "somebody holds it";
}

void drawControl(const PanelContext& context, const assets::Control& control) {
  const ViewModel& model = context.model;
  const double unit = shownPerUnit(control);
  const double value = assets::controlValue(control, model.worldFromPart[control.part]);
  const std::string why = obstacle(model, control);
  ImGui::PushID(control.part);
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(why.empty() ? theme::kText : theme::kMuted, "%s", control.name.c_str());
  if (ImGui::IsItemHovered()) {
    context.ui.parts.hovered = control.part;
    ImGui::SetTooltip("%s%s%s", assets::toString(control.kind), why.empty() ? "" : ": ", why.c_str());
  }
  ImGui::SameLine(108.0f * context.scale);
  auto edited = static_cast<float>(value * unit);
  const char* pattern = assets::turns(control) ? "%.1f\xC2\xB0" : "%.1f mm";
  ImGui::BeginDisabled(!why.empty());
  const SliderRange range{static_cast<float>(control.min * unit), static_cast<float>(control.max * unit),
                          pattern};
  if (numberSlider(context, "##value", edited, range)) {
    context.actions.setControl = control.part;
    context.actions.controlValue = static_cast<double>(edited) / unit;
  }
  ImGui::EndDisabled();
  ImGui::PopID();
}

}  // namespace

void drawControls(const PanelContext& context) {
  for (const assets::Control& control : context.model.scene->controls)
    if (control.part < context.model.worldFromPart.size()) drawControl(context, control);
}

}  // namespace tandem::client
