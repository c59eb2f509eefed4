// The small panel of measures over the scene: what is marked, its figures, and those that the session keeps.

#include <imgui.h>

#include <ctime>
#include <utility>

#include "client/session/document_words.h"
#include "client/viewer/panels.h"

namespace tandem::client {
namespace {

using namespace document;

constexpr float kWidth = 272.0f, kValueAt = 96.0f;  // pixels at scale 1
constexpr std::size_t kRowsShown = 5;

/// A value that ends at the right of the panel, less `room` pixels.
void rightAligned(const std::string& text, float room) {
  ImGui::SameLine(ImGui::GetContentRegionMax().x - room - ImGui::CalcTextSize(text.c_str()).x);
  ImGui::TextUnformatted(text.c_str());
}

void drawPlace(const PanelContext& context, const MeasuredPlace& place) {
  ImGui::PushFont(context.fonts.text);
  const std::string& name = context.model.scene->parts[place.part].name;
  const float room = mayWrite(context.model) ? 50.0f * context.scale : 0.0f;
  ImGui::TextUnformatted(shortenedTo(name, ImGui::GetContentRegionAvail().x - room).c_str());
  ImGui::PopFont();
  if (mayWrite(context.model)) {
    ImGui::SameLine(ImGui::GetContentRegionMax().x - 42.0f * context.scale);
    if (ImGui::SmallButton("Note")) context.actions.documentWishes.push_back(notePlace(place, context.model));
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("A note at this place that says all of this");
  }
  ImGui::PushFont(context.fonts.small);
  for (const std::string& line : placeInWords(place)) ImGui::TextColored(theme::kMuted, "%s", line.c_str());
  ImGui::PopFont();
}

void drawFigures(const PanelContext& context) {
  const bool keeps = mayWrite(context.model);
  const float room = keeps ? 50.0f * context.scale : 0.0f;
  for (const Figure& figure : context.model.measure.figures) {
    const char* name = kFigureNames[static_cast<std::size_t>(figure.kind)];
    ImGui::PushID(name);
    ImGui::TextColored(theme::kMuted, "%s", name);
    rightAligned(
        (figure.atLeast ? "at most " : "") + quantityInWords(documentKind(figure.kind), figure.value), room);
    if (keeps) {
      ImGui::SameLine(ImGui::GetContentRegionMax().x - 42.0f * context.scale);
      if (ImGui::SmallButton("Keep"))
        context.actions.documentWishes.push_back(keepFigure(figure, context.model));
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("For all, in the session's document");
    }
    ImGui::PopID();
  }
}

void drawMarks(const PanelContext& context) {
  MeasureUi& ui = context.ui.measures;
  const MeasureView& measured = context.model.measure;
  if (ui.marks.empty()) {
    ImGui::PushFont(context.fonts.small);
    ImGui::TextColored(theme::kMuted,
                       "M marks the place under the mouse, or where\nthe tool is. Two have a distance.");
    ImGui::PopFont();
    return;
  }
  if (measured.places.size() < ui.marks.size()) ImGui::TextColored(theme::kMuted, "measuring ...");
  for (std::size_t i = 0; i < measured.places.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    drawPlace(context, measured.places[i]);
    ImGui::PopID();
  }
  drawFigures(context);
}

void drawKeptRow(const PanelContext& context, const Entry& entry) {
  MeasureUi& ui = context.ui.measures;
  const Measure& measure = std::get<Measure>(entry.body);
  const bool chosen = ui.chosen == entry.id;
  ImGui::PushID(static_cast<int>(entry.id));
  if (ImGui::Selectable("##row", chosen)) chooseMeasure(ui, entry, context.model.worldFromPart.size());
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("%s of %s\n%s, %s", kMeasureNames[static_cast<std::size_t>(measure.kind)],
                      measure.name.c_str(), entry.authorName.c_str(),
                      ageInWords(entry.made, static_cast<std::int64_t>(std::time(nullptr))).c_str());
  ImGui::SameLine(0.01f);
  const std::string value = quantityInWords(measure.kind, measure.value);
  const float room = ImGui::CalcTextSize(value.c_str()).x + 8.0f * context.scale;
  ImGui::TextColored(theme::kMuted, "%s",
                     shortenedTo(measure.name, ImGui::GetContentRegionAvail().x - room).c_str());
  rightAligned(value, 0.0f);
  ImGui::PopID();
}

/// The measures that the session keeps.
void drawKept(const PanelContext& context) {
  if (context.model.document == nullptr) return;
  const std::vector<const Entry*> rows = measureRows(*context.model.document);
  if (rows.empty()) return;
  ImGui::Separator();
  const float line = ImGui::GetTextLineHeightWithSpacing();
  ImGui::BeginChild("kept",
                    ImVec2(0.0f, line * static_cast<float>(std::min(rows.size(), kRowsShown)) + 2.0f));
  for (const Entry* entry : rows) drawKeptRow(context, *entry);
  ImGui::EndChild();
  const Entry* chosen = context.model.document->find(context.ui.measures.chosen);
  if (chosen == nullptr || chosen->removed() || !mayWrite(context.model)) return;
  if (ImGui::SmallButton("Remove")) {
    context.actions.documentWishes.push_back(
        {DocumentWish::Kind::change, {chosen->id, chosen->revision, Removed{}}});
    context.ui.measures.chosen = 0;
    context.ui.measures.marks.clear();
  }
}

}  // namespace

void drawMeasures(const PanelContext& context, const Rect& viewport) {
  MeasureUi& ui = context.ui.measures;
  if (!ui.open) return;
  const float width = std::min(kWidth * context.scale, static_cast<float>(viewport.size().x) - 24.0f);
  ImGui::SetNextWindowPos(
      {static_cast<float>(viewport.min.x) + 12.0f, static_cast<float>(viewport.max.y) - 12.0f},
      ImGuiCond_Always, {0.0f, 1.0f});
  ImGui::SetNextWindowSize({width, 0.0f});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 6.0f);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, theme::kPanel);
  ImGui::Begin("##measure", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav);
  ImGui::PushFont(context.fonts.strong);
  ImGui::TextUnformatted("Measure");
  ImGui::PopFont();
  ImGui::SameLine(ImGui::GetContentRegionMax().x - 46.0f * context.scale);
  if (ImGui::SmallButton(ui.marks.empty() ? "Close" : "Clear")) clearMeasure(ui);
  drawMarks(context);
  drawKept(context);
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
}

}  // namespace tandem::client
