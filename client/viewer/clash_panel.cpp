#include <imgui.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <utility>

#include "client/marks/verdict_list.h"
#include "client/session/document_words.h"
#include "client/viewer/panels.h"

namespace tandem::client {
namespace {

constexpr std::size_t kMostKept = 500;  // at once: as many changes may wait

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

/// Keeps what was found for all, with a status. False if the document says so already.
bool drawKeep(const PanelContext& context) {
  const ClashSearchView& search = context.model.clashes;
  if (search.running || !mayWrite(context.model) || context.model.documentStanding.unsent > 0) return false;
  const std::vector<document::Change>& changes = context.ui.clashListing.changes();
  if (changes.empty()) return false;
  const std::size_t count = std::min(changes.size(), kMostKept);
  char text[64];
  std::snprintf(text, sizeof text, "Keep %zu", count);
  if (ImGui::Button(text))
    for (std::size_t i = 0; i < count; ++i)
      context.actions.documentWishes.push_back({DocumentWish::Kind::change, changes[i]});
  if (ImGui::IsItemHovered()) {
    const MergeCounts counts = countChanges(*context.model.document, changes);
    ImGui::SetTooltip("In the session's document, with a status:\n%zu new, %zu gone, %zu back, %zu changed",
                      counts.added, counts.resolved, counts.reopened, counts.deeper);
  }
  return true;
}

/// Back from where a click led.
void drawBack(const PanelContext& context) {
  if (ImGui::Button("Back")) context.ui.notes.goBack = true;
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("The view from before  (B)");
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

/// What is said of a line beside its depth: who gave its status and when, or what the search remarked.
std::string saidOf(const ClashLine& line) {
  if (!line.verdict) return line.row.note;
  const std::string by = judgedBy(*line.verdict, static_cast<std::int64_t>(std::time(nullptr)));
  return line.row.note.empty() ? by : by + "; " + line.row.note;
}

void drawClashRow(const PanelContext& context, const ClashLine& line) {
  ClashUi& ui = context.ui.clashes;
  const ClashRow& row = line.row;
  const bool chosen = ui.a == line.a && ui.b == line.b;
  ImGui::PushID(static_cast<int>(line.a));
  ImGui::PushID(static_cast<int>(line.b));
  const ImVec2 corner = ImGui::GetCursorPos();
  const float height = ImGui::GetTextLineHeight();
  if (ImGui::Selectable("##row", chosen, 0, ImVec2(0.0f, 2.0f * height + 2.0f * context.scale))) {
    ui.a = chosen ? kNoPart : line.a;
    ui.b = chosen ? kNoPart : line.b;
    ui.fly = !chosen;
  }
  const std::string said = saidOf(line);
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("%s\n%s\n%s%s%s", row.first.c_str(), row.second.c_str(), row.measure.c_str(),
                      said.empty() ? "" : "\n", said.c_str());
  const ImVec2 after = ImGui::GetCursorPos();
  ImGui::SetCursorPos(corner);
  drawNames(context, row, chosen);
  ImGui::SetCursorPos(ImVec2(corner.x, corner.y + height + 1.0f));
  ImGui::PushFont(context.fonts.small);
  ImGui::TextColored(row.found != nullptr ? colourOf(*row.found) : theme::kMuted, "%s", row.measure.c_str());
  if (!said.empty()) {
    ImGui::SameLine();
    ImGui::TextColored(theme::kMuted, "%s", shortenedTo(said, ImGui::GetContentRegionAvail().x).c_str());
  }
  ImGui::PopFont();
  ImGui::SetCursorPos(after);
  ImGui::PopID();
  ImGui::PopID();
}

void drawGroup(const PanelContext& context, const ClashGroup& group) {
  ImGui::PushFont(context.fonts.small);
  if (!group.title.empty())
    ImGui::TextColored(theme::colour(group.colour), "%s  %zu", group.title.c_str(), group.lines.size());
  ImGui::PopFont();
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(group.lines.size()));
  while (clipper.Step())
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i)
      drawClashRow(context, group.lines[static_cast<std::size_t>(i)]);
}

/// The status of the chosen clash with its remark, to be changed.
void drawVerdict(const PanelContext& context, const document::Entry& entry) {
  ClashUi& ui = context.ui.clashes;
  const auto& verdict = std::get<document::ClashVerdict>(entry.body);
  const VerdictWords words = verdictWords(verdict.text);
  if (ui.remarkOf != entry.revision) {
    ui.remarkOf = entry.revision;
    std::snprintf(ui.remark.data(), ui.remark.size(), "%s", words.remark.c_str());
  }
  const auto give = [&](document::ClashStatus status) {
    context.actions.documentWishes.push_back(
        {DocumentWish::Kind::change, judge(entry, status, {ownName(context.model), ui.remark.data()})});
  };
  ImGui::Separator();
  ImGui::SetNextItemWidth(-1.0f);
  const char* now = document::kClashStatusNames[static_cast<std::size_t>(verdict.status)];
  if (ImGui::BeginCombo("##status", now)) {
    for (std::size_t i = 0; i < document::kClashStatusNames.size(); ++i) {
      const auto status = static_cast<document::ClashStatus>(i);
      if (ImGui::Selectable(document::kClashStatusNames[i], status == verdict.status) &&
          status != verdict.status)
        give(status);
    }
    ImGui::EndCombo();
  }
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::InputTextWithHint("##remark", "Remark (Enter)", ui.remark.data(), ui.remark.size(),
                               ImGuiInputTextFlags_EnterReturnsTrue) &&
      words.remark != ui.remark.data())
    give(verdict.status);
}

void drawRows(const PanelContext& context, const ClashFindings* findings) {
  const ClashUi& ui = context.ui.clashes;
  const std::vector<ClashGroup>& groups = context.ui.clashListing.groups();
  const document::Entry* chosen = nullptr;
  for (const ClashGroup& group : groups)
    for (const ClashLine& line : group.lines)
      if (line.a == ui.a && line.b == ui.b && mayWrite(context.model) && line.verdict)
        chosen = &*line.verdict;
  const float below = chosen == nullptr ? 0.0f : -2.0f * ImGui::GetFrameHeightWithSpacing() - 6.0f;
  ImGui::BeginChild("clashes", ImVec2(0.0f, below));
  for (const ClashGroup& group : groups) drawGroup(context, group);
  if (groups.empty() && findings != nullptr) ImGui::TextDisabled("Nothing overlaps or comes that near");
  ImGui::EndChild();
  if (chosen != nullptr) drawVerdict(context, *chosen);
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
  context.ui.clashListing.update(context.model, ui);
  if (findings != nullptr) {
    drawCounts(*findings);
    ImGui::Checkbox("Touching, too", &ui.touches);
    ImGui::SameLine();
    ImGui::Checkbox("By part", &ui.byPart);
    if (drawKeep(context) && context.ui.notes.back) ImGui::SameLine();
  }
  if (context.ui.notes.back) drawBack(context);
  ImGui::Separator();
  drawRows(context, findings);
}

}  // namespace tandem::client
