// The panel of notes and views: the list, the thread of the chosen note, and what is being written.

#include <imgui.h>

#include <utility>

#include "assets/base/utc_time.h"
#include "client/marks/note_list.h"
#include "client/session/document_words.h"
#include "client/viewer/panels.h"

namespace tandem::client {
namespace {

using namespace document;

void want(const PanelContext& context, DocumentWish wish) {
  context.actions.documentWishes.push_back(std::move(wish));
}

void reversalButton(const PanelContext& context, const char* name, DocumentWish::Kind kind,
                    const std::string& what, const char* keys) {
  ImGui::BeginDisabled(what.empty());
  if (ImGui::Button(name)) want(context, {kind, {}});
  ImGui::EndDisabled();
  if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
    ImGui::SetTooltip("%s  (%s)", what.empty() ? "nothing of yours" : what.c_str(), keys);
}

/// The buttons on top: write, undo, redo, and back from where a click led.
void drawButtons(const PanelContext& context) {
  const ViewModel& model = context.model;
  NoteUi& ui = context.ui.notes;
  if (mayWrite(model)) {
    if (ImGui::Button("Write  (N)") && !ui.draft) {
      ui.draft = noteAt(model, model.hand.touched, model.hand.worldFromProxy.position);
      ui.focus = true;
    }
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("N: a note at the place under the mouse\nThis button: at the tip of your tool");
    ImGui::SameLine();
    reversalButton(context, "Undo", DocumentWish::Kind::undo, model.documentStanding.undo, "Ctrl + Z");
    ImGui::SameLine();
    reversalButton(context, "Redo", DocumentWish::Kind::redo, model.documentStanding.redo, "Ctrl + Y");
  }
  if (!ui.back) return;
  if (mayWrite(model)) ImGui::SameLine();
  if (ImGui::Button("Back")) ui.goBack = true;
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("The view from before  (B)");
}

/// The note that is being written.
void drawDraft(const PanelContext& context) {
  NoteUi& ui = context.ui.notes;
  if (!ui.draft) return;
  const PartId part = ui.draft->part;
  ImGui::TextColored(theme::kMuted, "%s",
                     part == kNoPart ? "A note in the room" : context.model.scene->parts[part].name.c_str());
  if (ui.focus) ImGui::SetKeyboardFocusHere();
  ui.focus = false;
  const ImVec2 size(-1.0f, 3.6f * ImGui::GetTextLineHeight());
  const bool entered = ImGui::InputTextMultiline(
      "##text", ui.text.data(), ui.text.size(), size,
      ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_CtrlEnterForNewLine);
  const bool pinned = (ImGui::Button("Pin it  (Enter)") || entered) && ui.text[0] != '\0';
  ImGui::SameLine();
  const bool dropped = ImGui::Button("Drop it");
  if (pinned) {
    ui.draft->text = ui.text.data();
    want(context, newEntry(*ui.draft));
  }
  if (!pinned && !dropped) return;
  ui.draft.reset();
  ui.text = {};
}

void drawStatusChoice(const PanelContext& context, const NoteRow& row) {
  ImGui::SetNextItemWidth(0.48f * ImGui::GetContentRegionAvail().x);
  if (ImGui::BeginCombo("##status", kNoteStatusNames[static_cast<std::size_t>(row.note->status)])) {
    for (std::size_t i = 0; i < kNoteStatusNames.size(); ++i) {
      const auto status = static_cast<NoteStatus>(i);
      if (ImGui::Selectable(kNoteStatusNames[i], status == row.note->status) && status != row.note->status)
        want(context, changedNote(*row.entry, [&](Note& note) { note.status = status; }));
    }
    ImGui::EndCombo();
  }
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-1.0f);
  const std::string& assignee = row.note->assignee;
  if (!ImGui::BeginCombo("##assignee", assignee.empty() ? "for nobody" : ("for " + assignee).c_str())) return;
  const auto choice = [&](const std::string& name, const char* shown) {
    if (ImGui::Selectable(shown, name == assignee) && name != assignee)
      want(context, changedNote(*row.entry, [&](Note& note) { note.assignee = name; }));
  };
  choice("", "nobody");
  for (const SiteView& site : context.model.sites) choice(site.info.name, site.info.name.c_str());
  ImGui::EndCombo();
}

/// The thread of the chosen note, and what can be done with it.
void drawThread(const PanelContext& context, const NoteRow& row) {
  NoteUi& ui = context.ui.notes;
  const auto now = systemUnixTime();
  ImGui::Indent(10.0f * context.scale);
  ImGui::TextWrapped("%s", row.note->text.c_str());
  for (const Entry* reply : row.replies) {
    ImGui::PushFont(context.fonts.small);
    ImGui::TextColored(theme::kMuted, "%s %s", reply->authorName.c_str(),
                       ageInWords(reply->made, now).c_str());
    ImGui::PopFont();
    ImGui::TextWrapped("%s", std::get<Comment>(reply->body).text.c_str());
  }
  if (mayWrite(context.model)) {
    drawStatusChoice(context, row);
    ImGui::SetNextItemWidth(-1.0f);
    if (ImGui::InputTextWithHint("##reply", "Reply (Enter)", ui.reply.data(), ui.reply.size(),
                                 ImGuiInputTextFlags_EnterReturnsTrue) &&
        ui.reply[0] != '\0') {
      want(context, newEntry(Comment{row.entry->id, ui.reply.data()}));
      ui.reply = {};
    }
  }
  ImGui::Unindent(10.0f * context.scale);
}

void drawNoteRow(const PanelContext& context, const NoteRow& row) {
  NoteUi& ui = context.ui.notes;
  const bool chosen = ui.chosen == row.entry->id;
  const auto now = systemUnixTime();
  ImGui::PushID(static_cast<int>(row.entry->id));
  const ImVec2 corner = ImGui::GetCursorPos();
  const float line = ImGui::GetTextLineHeight();
  if (ImGui::Selectable("##row", chosen, 0, ImVec2(0.0f, 2.0f * line + 2.0f * context.scale))) {
    ui.chosen = chosen ? 0 : row.entry->id;
    ui.flyTo = ui.chosen;
    ui.reply = {};
  }
  const ImVec2 after = ImGui::GetCursorPos();
  ImGui::SetCursorPos(corner);
  ImGui::TextColored(theme::colour(noteColour(row.note->status)), "%llu",
                     static_cast<unsigned long long>(row.entry->id));
  ImGui::SameLine();
  const std::string text = shortenedTo(shortened(row.note->text, 200), ImGui::GetContentRegionAvail().x);
  ImGui::TextUnformatted(text.c_str());
  ImGui::SetCursorPos(ImVec2(corner.x, corner.y + line + 1.0f));
  ImGui::PushFont(context.fonts.small);
  const std::string words = byline(row, now);
  ImGui::TextColored(theme::kMuted, "%s", shortenedTo(words, ImGui::GetContentRegionAvail().x).c_str());
  ImGui::PopFont();
  ImGui::SetCursorPos(after);
  if (chosen) drawThread(context, row);
  ImGui::PopID();
}

void drawViews(const PanelContext& context) {
  NoteUi& ui = context.ui.notes;
  for (const Entry* entry : viewRows(*context.model.document)) {
    ImGui::PushID(static_cast<int>(entry->id));
    if (ImGui::Selectable(std::get<NamedView>(entry->body).name.c_str())) ui.flyTo = entry->id;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s sees this", entry->authorName.c_str());
    ImGui::PopID();
  }
  if (!mayWrite(context.model)) return;
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::InputTextWithHint("##view", "Keep this view as (Enter)", ui.viewName.data(), ui.viewName.size(),
                               ImGuiInputTextFlags_EnterReturnsTrue) &&
      ui.viewName[0] != '\0')
    ui.keepsView = true;
}

}  // namespace

void drawNotes(const PanelContext& context) {
  NoteUi& ui = context.ui.notes;
  const Document& document = *context.model.document;
  drawButtons(context);
  drawDraft(context);
  const std::vector<NoteRow> rows = noteRows(document, ui.closedToo);
  if (!rows.empty() && std::exchange(ui.choosesFirst, false)) ui.chosen = rows.front().entry->id;
  ImGui::Checkbox("Closed notes, too", &ui.closedToo);
  if (context.model.documentStanding.unsent > 0) {
    ImGui::SameLine();
    ImGui::TextColored(theme::kWarning, "%zu not sent yet", context.model.documentStanding.unsent);
  }
  ImGui::Separator();
  ImGui::BeginChild("notes", ImVec2(0.0f, -0.28f * ImGui::GetContentRegionAvail().y));
  for (const NoteRow& row : rows) drawNoteRow(context, row);
  if (rows.empty()) ImGui::TextDisabled("No notes yet");
  ImGui::EndChild();
  ImGui::Separator();
  ImGui::TextColored(theme::kMuted, "Views");
  ImGui::BeginChild("views");
  drawViews(context);
  ImGui::EndChild();
}

}  // namespace tandem::client
