#include <imgui.h>

#include <cstdio>

#include "client/viewer/panels.h"

namespace tandem::client {
namespace {

void requestSearch(const PanelContext& context) {
  context.ui.clashes.requested = true;
  context.actions.findClashes = context.ui.clashes.question;
}

/// The inputs of the search.
void drawQuestion(const PanelContext& context) {
  ClashUi& ui = context.ui.clashes;
  int atRest = ui.question.atRest ? 1 : 0;
  bool changed = ImGui::RadioButton("As they stand", &atRest, 0);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("Parts where they are now in the session");
  ImGui::SameLine();
  changed = ImGui::RadioButton("At rest", &atRest, 1) || changed;
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("Parts where the scene has them");
  ui.question.atRest = atRest == 1;
  auto millimetres = static_cast<float>(1e3 * ui.question.clearance);
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(theme::kMuted, "Nearer than");
  ImGui::SameLine(108.0f * context.scale);
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::InputFloat("##clearance", &millimetres, 0.0f, 0.0f, "%.3g mm") && millimetres >= 0.0f)
    ui.question.clearance = 1e-3 * static_cast<double>(millimetres);
  changed = ImGui::IsItemDeactivatedAfterEdit() || changed;
  if (changed && ui.requested) requestSearch(context);
}

void drawProgress(const PanelContext& context) {
  const ClashSearchView& search = context.model.clashes;
  if (!search.running) {
    if (ImGui::Button("Look again", ImVec2(-1.0f, 0.0f))) requestSearch(context);
    return;
  }
  const float share =
      search.pairs > 0 ? static_cast<float>(search.done) / static_cast<float>(search.pairs) : 0.0f;
  char text[64];
  std::snprintf(text, sizeof text, "%zu of %zu pairs", search.done, search.pairs);
  ImGui::ProgressBar(share, ImVec2(-56.0f * context.scale, 0.0f), text);
  ImGui::SameLine();
  if (ImGui::Button("Stop", ImVec2(-1.0f, 0.0f))) context.actions.stopClashes = true;
}

void drawCounts(const ClashFindings& findings) {
  const ClashCounts counts = countClashes(findings);
  const ImVec4 colour = counts.hard > 0 ? theme::kBad : counts.atRest > 0 ? theme::kWarning : theme::kGood;
  ImGui::TextColored(colour, "%zu overlap,", counts.hard + counts.atRest);
  ImGui::SameLine(0.0f, 5.0f);
  ImGui::TextColored(theme::kMuted, "%zu at rest, %zu near", counts.atRest, counts.near);
  if (counts.passThrough > 0)
    ImGui::TextColored(theme::kMuted, "%zu may pass through each other", counts.passThrough);
  if (!findings.complete) ImGui::TextColored(theme::kWarning, "Stopped: not all pairs were measured");
}

ImVec4 colourOf(const FoundClash& found) {
  if (!found.clash.mayCollide || found.clash.kind == ClashKind::touch) return theme::kMuted;
  if (found.clash.kind == ClashKind::clearance) return theme::kAccent;
  return found.overlapsAtRest ? theme::kWarning : theme::kBad;
}

/// Draws the names of both parts; those of the chosen clash in the colours that the parts have in the scene.
void drawNames(const PanelContext& context, const ClashRow& row, bool chosen) {
  const float width = ImGui::GetContentRegionAvail().x;
  const std::string all = shortenedTo(row.first + ", " + row.second, width);
  if (!chosen || all.size() <= row.first.size() + 2) {
    ImGui::TextUnformatted(all.c_str());
    return;
  }
  ImGui::PushFont(context.fonts.text);
  ImGui::TextColored(theme::colour(0.85f * kClashColourA), "%s,", row.first.c_str());
  ImGui::SameLine(0.0f, ImGui::CalcTextSize(" ").x);
  ImGui::TextColored(theme::colour(0.9f * kClashColourB), "%s", all.substr(row.first.size() + 2).c_str());
  ImGui::PopFont();
}

void drawRow(const PanelContext& context, const ClashRow& row) {
  ClashUi& ui = context.ui.clashes;
  const Clash& clash = row.found->clash;
  const bool chosen = ui.a == clash.a && ui.b == clash.b;
  ImGui::PushID(static_cast<int>(clash.a));
  ImGui::PushID(static_cast<int>(clash.b));
  const ImVec2 corner = ImGui::GetCursorPos();
  const float line = ImGui::GetTextLineHeight();
  if (ImGui::Selectable("##row", chosen, 0, ImVec2(0.0f, 2.0f * line + 2.0f * context.scale))) {
    ui.a = chosen ? kNoPart : clash.a;
    ui.b = chosen ? kNoPart : clash.b;
    ui.fly = !chosen;
  }
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("%s\n%s\n%s%s%s", row.first.c_str(), row.second.c_str(), row.measure.c_str(),
                      row.note.empty() ? "" : "\n", row.note.c_str());
  const ImVec2 after = ImGui::GetCursorPos();
  ImGui::SetCursorPos(corner);
  drawNames(context, row, chosen);
  ImGui::SetCursorPos(ImVec2(corner.x, corner.y + line + 1.0f));
  ImGui::PushFont(context.fonts.small);
  ImGui::TextColored(colourOf(*row.found), "%s", row.measure.c_str());
  if (!row.note.empty()) {
    ImGui::SameLine();
    ImGui::TextColored(theme::kMuted, "%s", shortenedTo(row.note, ImGui::GetContentRegionAvail().x).c_str());
  }
  ImGui::PopFont();
  ImGui::SetCursorPos(after);
  ImGui::PopID();
  ImGui::PopID();
}

void drawRows(const PanelContext& context, const ClashFindings& findings) {
  const std::vector<ClashRow> rows = clashRows(findings, *context.model.scene, context.ui.clashes.touches);
  ImGui::BeginChild("clashes");
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(rows.size()));
  while (clipper.Step())
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i)
      drawRow(context, rows[static_cast<std::size_t>(i)]);
  if (rows.empty()) ImGui::TextDisabled("Nothing overlaps or comes that near");
  ImGui::EndChild();
}

}  // namespace

std::string shortenedTo(const std::string& text, float width) {
  if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
  std::string cut = text;
  while (!cut.empty() && ImGui::CalcTextSize((cut + "...").c_str()).x > width) {
    do cut.pop_back();
    while (!cut.empty() && (static_cast<unsigned char>(cut.back()) & 0xC0u) == 0x80u);
  }
  return cut + "...";
}

void drawClashes(const PanelContext& context) {
  ClashUi& ui = context.ui.clashes;
  const ClashFindings* findings = context.model.clashes.findings.get();
  if (!ui.requested) requestSearch(context);
  drawQuestion(context);
  drawProgress(context);
  if (findings == nullptr) return;
  drawCounts(*findings);
  ImGui::Checkbox("Touching parts, too", &ui.touches);
  ImGui::Separator();
  drawRows(context, *findings);
}

}  // namespace tandem::client
