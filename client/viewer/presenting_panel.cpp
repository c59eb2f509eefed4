// Who presents or shares sections, whether that is followed, and what people say to each other.

#include <imgui.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "assets/base/utc_time.h"
#include "client/base/readable.h"
#include "client/picture/colours.h"
#include "client/session/holding_words.h"
#include "client/session/said_parts.h"
#include "client/viewer/panels.h"

namespace tandem::client {
namespace {

/// A button that turns sharing on and off.
void shareButton(const PanelContext& context, const char* name, const char* stop, sync::Shares what,
                 const char* tip) {
  sync::Shares& shares = context.ui.shared.shares;
  if (ImGui::SmallButton(shares == what ? stop : name))
    shares = shares == what ? sync::Shares::nothing : what;
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tip);
}

/// Puts the name of a part, as a link, behind what was written.
void addName(ChatUi& chat, const std::string& name) {
  const std::string text = std::string(chat.text.data()) + '[' + name + "] ";
  if (text.size() < chat.text.size()) std::memcpy(chat.text.data(), text.c_str(), text.size() + 1);
}

/// Goes on in the same line if the next item, of this width, has room there.
void keepLine(float width) {
  ImGui::SameLine(0.0f, 0.0f);
  if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
}

/// Text that wraps between words, wherever in the line it begins.
void plainText(const std::string& text) {
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t space = text.find(' ', from);
    const std::size_t end = space == std::string::npos ? text.size() : space + 1;
    const std::string word = text.substr(from, end - from);
    keepLine(ImGui::CalcTextSize(word.c_str()).x);
    ImGui::TextUnformatted(word.c_str());
    from = end;
  }
}

/// A name that can be clicked: selects the part and flies there.
void partLink(const PanelContext& context, const SaidPiece& piece, int id) {
  const ImVec2 size = ImGui::CalcTextSize(piece.text.c_str());
  keepLine(size.x);
  ImGui::PushID(id);
  if (ImGui::InvisibleButton("##link", ImVec2(std::max(size.x, 1.0f), size.y))) {
    context.ui.parts.selected = piece.part;
    context.ui.parts.setHidden(piece.part, false);
    context.ui.fit = std::vector<PartId>{piece.part};
    context.ui.fitFlies = true;
  }
  if (ImGui::IsItemHovered()) context.ui.parts.hovered = piece.part;
  const ImVec2 min = ImGui::GetItemRectMin(), max = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImU32 colour = theme::packed(theme::kAccent);
  list.AddText(min, colour, piece.text.c_str());
  list.AddLine(ImVec2(min.x, max.y), max, colour);
  ImGui::PopID();
}

/// A line with who said it; what was said before this site came has its time.
void drawLine(const PanelContext& context, const ChatLine& chat) {
  const sync::SaidLine& line = chat.line;
  const SiteView* site = findSite(context.model, line.site);
  const glm::vec3 colour = site != nullptr ? srgb(site->info.colour) : glm::vec3(0.4f);
  ImGui::PushID(static_cast<int>(chat.number));
  if (chat.earlier) {
    ImGui::TextColored(theme::kMuted, "%s  ", clockTime(line.at, systemUnixTime()).c_str());
    ImGui::SameLine(0.0f, 0.0f);
  }
  ImGui::TextColored(theme::colour(0.82f * colour), "%s  ", line.name.c_str());
  int id = 0;
  for (const SaidPiece& piece : piecesOf(line.said, *context.model.scene)) {
    if (piece.part == kNoPart)
      plainText(piece.text);
    else
      partLink(context, piece, ++id);
  }
  ImGui::PopID();
}

/// The part that "Name it" puts into the message: selected, held or touched.
PartId partToName(const PanelContext& context) {
  const HandView& hand = context.model.hand;
  if (context.ui.parts.selected != kNoPart) return context.ui.parts.selected;
  return hand.held != kNoPart ? hand.held : hand.touched;
}

void drawInput(const PanelContext& context) {
  ChatUi& chat = context.ui.chat;
  const char* name = "+ part";
  const float room = ImGui::CalcTextSize(name).x + 3.0f * ImGui::GetStyle().FramePadding.x;
  ImGui::SetNextItemWidth(-room);
  const bool entered = ImGui::InputTextWithHint("##say", "Say to all (Enter)", chat.text.data(),
                                                chat.text.size(), ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::SameLine();
  const PartId part = partToName(context);
  ImGui::BeginDisabled(part == kNoPart);
  if (ImGui::SmallButton(name)) addName(chat, context.model.scene->parts[part].name);
  ImGui::EndDisabled();
  if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
    ImGui::SetTooltip("Links to the selected or touched part, as [name]");
  if (!entered || chat.text[0] == '\0') return;
  context.actions.says.push_back(saidWithLinks(chat.text.data(), *context.model.scene));
  chat.text = {};
  ImGui::SetKeyboardFocusHere(-1);
}

}  // namespace

void drawSharing(const PanelContext& context) {
  const ViewModel& model = context.model;
  SharedView& shared = context.ui.shared;
  if (const std::string words = sharingInWords(model, shared); !words.empty()) {
    ImGui::TextWrapped("%s", words.c_str());
    if (shared.shares == sync::Shares::nothing) {
      const bool follows = shared.following().followsSections();
      if (ImGui::SmallButton(follows ? "Stop following" : "Follow")) shared.setFollows(!follows);
      if (follows && ImGui::IsItemHovered())
        ImGui::SetTooltip("Your own sections%s come back",
                          shared.following().followsView() ? ", hidden parts and colours" : "");
    }
  }
  if (model.role == sync::Role::observer || model.sites.size() < 2) return;
  shareButton(context, "Present", "Stop presenting", sync::Shares::view,
              "The others follow your camera, sections, hidden parts, colours,\nexplosion and selection, "
              "and see the place under your mouse");
  ImGui::SameLine();
  shareButton(context, "Share sections", "Stop sharing", sync::Shares::sections,
              "The others' sections follow yours; what they cut away is not felt there either");
}

void drawChat(const PanelContext& context) {
  ChatUi& chat = context.ui.chat;
  const std::vector<ChatLine>& lines = context.model.chat;
  if (!lines.empty()) {
    const float height = std::min(6.0f, 1.6f * static_cast<float>(lines.size()));
    ImGui::BeginChild("lines", ImVec2(0.0f, height * ImGui::GetTextLineHeightWithSpacing()));
    for (const ChatLine& line : lines) drawLine(context, line);
    if (std::exchange(chat.lines, lines.back().number) != lines.back().number) ImGui::SetScrollHereY(1.0f);
    ImGui::EndChild();
  }
  if (context.model.role != sync::Role::observer) drawInput(context);
}

}  // namespace tandem::client
