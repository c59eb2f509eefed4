#include "client/viewer/panels.h"

#include <imgui.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "assets/scene/stated_tolerances.h"
#include "client/picture/colours.h"

namespace tandem::client {
namespace {

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                    ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus;
constexpr ImGuiWindowFlags kFloating =
    kFixed | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

void place(double x, double y, double width, double height) {
  ImGui::SetNextWindowPos(ImVec2(static_cast<float>(x), static_cast<float>(y)));
  ImGui::SetNextWindowSize(ImVec2(static_cast<float>(width), static_cast<float>(height)));
}

void heading(const PanelContext& context, const char* text) {
  ImGui::PushFont(context.fonts.strong);
  ImGui::TextUnformatted(text);
  ImGui::PopFont();
}

template <typename Draw>
void section(const PanelContext& context, const char* title, Draw draw, bool opens = true) {
  ImGui::PushFont(context.fonts.strong);
  ImGui::PushStyleVar(ImGuiStyleVar_FrameBorderSize, 0.0f);
  const bool open = ImGui::CollapsingHeader(title, opens ? ImGuiTreeNodeFlags_DefaultOpen : 0);
  ImGui::PopStyleVar();
  ImGui::PopFont();
  if (!open) return;
  ImGui::PushID(title);
  draw(context);
  ImGui::PopID();
  ImGui::Dummy(ImVec2(0.0f, 1.0f));
}

/// The button that sets all forces to zero. It stands on top, in red, so that it is found at once.
void drawZeroForce(const PanelContext& context) {
  HandSettings& settings = context.actions.settings;
  const bool off = settings.zeroForce;
  const ImVec4 fill = off ? theme::kBad : theme::kRaised;
  ImGui::PushStyleColor(ImGuiCol_Button, fill);
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered,
                        off ? ImVec4(0.70f, 0.12f, 0.10f, 1.0f) : ImVec4(1.0f, 0.93f, 0.92f, 1.0f));
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, ImVec4(0.62f, 0.10f, 0.08f, 1.0f));
  ImGui::PushStyleColor(ImGuiCol_Text, off ? ImVec4(1, 1, 1, 1) : theme::kBad);
  ImGui::PushStyleColor(ImGuiCol_Border, theme::kBad);
  ImGui::PushFont(context.fonts.strong);
  const char* text = off ? "FORCE IS OFF  (Space turns it on)" : "Zero force  (Space)";
  if (ImGui::Button(text, ImVec2(-1.0f, 32.0f * context.scale))) {
    settings.zeroForce = !off;
    context.actions.settingsChanged = true;
  }
  ImGui::PopFont();
  ImGui::PopStyleColor(5);
}

void partCount(const PanelContext& context) {
  if (!context.model.scene) return;
  char text[64];
  std::snprintf(text, sizeof text, "%zu parts", context.model.scene->parts.size());
  ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(text).x);
  ImGui::TextColored(theme::kMuted, "%s", text);
}

/// The left panel's tabs: parts, clashes and notes.
void drawTabs(const PanelContext& context, PartTree& tree) {
  ClashUi& clashes = context.ui.clashes;
  NoteUi& notes = context.ui.notes;
  const bool wanted = clashes.open && !clashes.requested;  // opened by other means than a click on the tab
  if (!ImGui::BeginTabBar("##tabs")) return;
  const auto tab = [&](const char* name, ImGuiTabItemFlags flags, const auto& draw) {
    ImGui::PushFont(context.fonts.strong);
    const bool open = ImGui::BeginTabItem(name, nullptr, flags);
    ImGui::PopFont();
    if (!open) return false;
    draw();
    ImGui::EndTabItem();
    return true;
  };
  tab("Parts", 0, [&] { tree.draw(context); });
  if (context.model.clashes.possible)
    clashes.open =
        tab("Clashes", wanted ? ImGuiTabItemFlags_SetSelected : 0, [&] { drawClashes(context); }) || wanted;
  if (context.model.document != nullptr)
    notes.open =
        tab("Notes", notes.wanted ? ImGuiTabItemFlags_SetSelected : 0, [&] { drawNotes(context); }) ||
        notes.wanted;
  notes.wanted = false;
  ImGui::EndTabBar();
}

void drawLeft(const PanelContext& context, PartTree& tree, const Rect& rect) {
  place(rect.min.x, rect.min.y, rect.size().x, rect.size().y);
  ImGui::Begin("##parts", nullptr, kFixed);
  if (context.model.clashes.possible || context.model.document != nullptr) {
    drawTabs(context, tree);
  } else {
    heading(context, "Parts");
    partCount(context);
    tree.draw(context);
  }
  ImGui::End();
}

void drawRight(const PanelContext& context, const Rect& rect) {
  place(rect.min.x, rect.min.y, rect.size().x, rect.size().y);
  ImGui::Begin("##session", nullptr, kFixed);
  if (!context.model.replay) drawZeroForce(context);
  if (context.model.wayOut.part != kNoPart) section(context, "Way out", drawWayOut);
  section(context, "People", drawPeople);
  ChatUi& chat = context.ui.chat;
  if (!context.model.chat.empty() && !std::exchange(chat.opened, true)) ImGui::SetNextItemOpen(true);
  const bool anybody = context.model.sites.size() > 1 || !context.model.chat.empty();
  if (!context.model.replay && anybody) section(context, "Chat", drawChat, false);
  if (context.model.role != sync::Role::observer) section(context, "Hand", drawHand);
  if (context.model.scene && !context.model.scene->controls.empty())
    section(context, "Controls", drawControls);
  const PartId selected = context.ui.parts.selected;
  if (context.model.scene && selected != kNoPart &&
      !assets::statedTolerances(*context.model.scene, selected).empty())
    section(context, "Tolerances", drawTolerances);
  if (!context.model.replay) section(context, "Network", drawNetwork);
  if (context.model.scene) section(context, "Sections", drawSections, context.ui.sections.any());
  if (context.model.scene && context.model.scene->parts.size() > 1)
    section(context, "Explode", drawExplode, context.ui.parts.style.explode > 0.0);
  section(context, "Settings", drawSettings);
  ImGui::End();
}

void separatorDot() {
  ImGui::SameLine(0.0f, 10.0f);
  ImGui::TextColored(theme::kLine, "|");
  ImGui::SameLine(0.0f, 10.0f);
}

void drawOwnHand(const PanelContext& context) {
  const ViewModel& model = context.model;
  if (model.connection.roundTrip_ms > 0.0) {
    separatorDot();
    ImGui::TextColored(theme::kMuted, "%.0f ms", model.connection.roundTrip_ms);
  }
  separatorDot();
  const PartDisplay& parts = context.ui.parts;
  const PartId inReach = parts.inReach != kNoPart ? parts.inReach : model.hand.touched;
  if (model.hand.held != kNoPart && model.scene) {
    ImGui::Text("Holding %s", model.scene->parts[model.hand.held].name.c_str());
  } else if (inReach != kNoPart && model.scene) {
    ImGui::Text("At %s", model.scene->parts[inReach].name.c_str());
  } else {
    ImGui::TextColored(theme::kMuted, "Nothing in reach");
  }
  separatorDot();
  ImGui::Text("%.2f N", glm::length(model.hand.force));
  if (context.actions.settings.zeroForce) {
    separatorDot();
    ImGui::TextColored(theme::kBad, "force is off");
  }
  if (hasFault(model)) {
    separatorDot();
    ImGui::TextColored(theme::kBad, "fault: force is off  (C clears it)");
  }
}

/// In a replay: the activity of the person whose camera is followed; nothing while nobody is.
void drawFollowed(const PanelContext& context) {
  const SiteView* site = findSite(context.model, context.ui.following);
  if (context.ui.following == kNoSite || site == nullptr) return;
  separatorDot();
  ImGui::Text("%s %s", site->info.name.c_str(), activityOf(context.model, *site).c_str());
  separatorDot();
  ImGui::Text("%.2f N", glm::length(site->presence.force));
}

void drawStatus(const PanelContext& context, const Rect& rect) {
  const ViewModel& model = context.model;
  place(rect.min.x, rect.min.y, rect.size().x, rect.size().y);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(12.0f, 4.0f));
  ImGui::Begin("##status", nullptr, kFixed | ImGuiWindowFlags_NoScrollbar);
  const ImVec4 state = model.replay                 ? theme::kMuted
                       : model.connection.connected ? theme::kGood
                                                    : theme::kWarning;
  colourDot(glm::vec3(state.x, state.y, state.z));
  ImGui::SameLine(0.0f, 4.0f);
  ImGui::TextUnformatted(model.replay ? "replay" : model.connection.status.c_str());
  model.replay ? drawFollowed(context) : drawOwnHand(context);
  if (const std::string sharing = sharingInWords(model, context.ui.shared); !sharing.empty()) {
    separatorDot();
    ImGui::TextUnformatted(sharing.c_str());
  }
  char refining[48] = "", right[96] = "F1 help";
  if (model.loop.refined < 1.0)
    std::snprintf(refining, sizeof refining, "contact is refined: %.0f %%     ", 100.0 * model.loop.refined);
  if (context.live)
    std::snprintf(right, sizeof right, "%s%.0f fps     F1 help", refining,
                  static_cast<double>(ImGui::GetIO().Framerate));
  ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(right).x);
  ImGui::TextColored(theme::kMuted, "%s", right);
  ImGui::End();
  ImGui::PopStyleVar();
}

}  // namespace

Rect drawPanels(const PanelContext& context, PartTree& tree, const glm::dvec2& window) {
  const double scale = context.scale;
  const double status = ImGui::GetTextLineHeight() + 10.0;
  const double left = std::min(270.0 * scale, 0.25 * window.x),
               right = std::min(310.0 * scale, 0.3 * window.x);
  const double bottom = window.y - status;
  drawLeft(context, tree, {{0.0, 0.0}, {left, bottom}});
  drawRight(context, {{window.x - right, 0.0}, {window.x, bottom}});
  drawStatus(context, {{0.0, bottom}, window});
  return {{left, 0.0}, {window.x - right, bottom}};
}

void drawLabels(const View& view, const Rect& viewport, const std::vector<Label>& labels,
                const PanelContext& context) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.PushClipRect({static_cast<float>(viewport.min.x), static_cast<float>(viewport.min.y)},
                    {static_cast<float>(viewport.max.x), static_cast<float>(viewport.max.y)});
  ImFont* font = context.fonts.small;
  for (const Label& label : labels) {
    const auto at = view.project(label.world);
    if (!at) continue;
    const glm::dvec2 p = viewport.min + *at + label.offset * static_cast<double>(context.scale);
    const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e9f, 0.0f, label.text.c_str());
    const ImVec2 min(static_cast<float>(p.x), static_cast<float>(p.y));
    const ImVec2 max(min.x + size.x + 10.0f, min.y + size.y + 4.0f);
    list.AddRectFilled(min, max, theme::packed(theme::colour(0.82f * label.colour), 0.92f), 4.0f);
    list.AddText(font, font->FontSize, {min.x + 5.0f, min.y + 2.0f}, IM_COL32_WHITE, label.text.c_str());
  }
  list.PopClipRect();
}

void drawNotices(const PanelContext& context, const Rect& viewport) {
  constexpr double kShown = 7.0, kFade = 1.0;  // s
  const auto& notices = context.model.notices;
  double y = viewport.min.y + 14.0 * context.scale;
  int drawn = 0;
  for (auto it = notices.rbegin(); it != notices.rend() && drawn < 4; ++it) {
    if (it->age > kShown) continue;
    const auto alpha = static_cast<float>(std::clamp((kShown - it->age) / kFade, 0.0, 1.0));
    const ImVec4 colour = it->level == Notice::Level::error     ? theme::kBad
                          : it->level == Notice::Level::warning ? theme::kWarning
                                                                : theme::kAccent;
    char id[24];
    std::snprintf(id, sizeof id, "##notice%d", drawn++);
    ImGui::SetNextWindowPos(
        {static_cast<float>(0.5 * (viewport.min.x + viewport.max.x)), static_cast<float>(y)},
        ImGuiCond_Always, {0.5f, 0.0f});
    ImGui::PushStyleVar(ImGuiStyleVar_Alpha, alpha);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 5.0f);
    ImGui::PushStyleColor(ImGuiCol_WindowBg, theme::kRaised);
    ImGui::Begin(id, nullptr, kFloating | ImGuiWindowFlags_NoInputs);
    colourDot(glm::vec3(colour.x, colour.y, colour.z));
    ImGui::SameLine();
    ImGui::TextUnformatted(it->text.c_str());
    y += static_cast<double>(ImGui::GetWindowSize().y) + 6.0;
    ImGui::End();
    ImGui::PopStyleColor();
    ImGui::PopStyleVar(2);
  }
}

void drawReplayBar(const PanelContext& context, const Rect& viewport) {
  const ViewModel& model = context.model;
  if (!model.replay) return;
  const double width = std::min(720.0 * static_cast<double>(context.scale), viewport.size().x - 32.0);
  ImGui::SetNextWindowPos({static_cast<float>(0.5 * (viewport.min.x + viewport.max.x)),
                           static_cast<float>(viewport.max.y - 14.0)},
                          ImGuiCond_Always, {0.5f, 1.0f});
  ImGui::SetNextWindowSize({static_cast<float>(width), 0.0f});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 6.0f);
  ImGui::Begin("##replay", nullptr, kFixed | ImGuiWindowFlags_AlwaysAutoResize);
  if (ImGui::Button(model.playing ? "Pause" : "Play", ImVec2(64.0f * context.scale, 0.0f)))
    context.actions.togglePlay = true;
  ImGui::SameLine();
  auto time = static_cast<float>(model.time);
  char text[48];
  std::snprintf(text, sizeof text, "%.1f s of %.1f s", model.duration, model.duration);
  const float right = ImGui::GetContentRegionMax().x - 86.0f * context.scale;
  const float room =
      ImGui::CalcTextSize(text).x + 12.0f * context.scale;  // for the longest text that the time becomes
  ImGui::SetNextItemWidth(right - room - ImGui::GetCursorPosX());
  if (ImGui::SliderFloat("##time", &time, 0.0f, static_cast<float>(model.duration), "")) {
    context.actions.seek = true;
    context.actions.seekTo = static_cast<double>(time);
  }
  std::snprintf(text, sizeof text, "%.1f s of %.1f s", model.time, model.duration);
  ImGui::SameLine(right - ImGui::CalcTextSize(text).x);
  ImGui::TextUnformatted(text);
  ImGui::SameLine(right + 8.0f * context.scale);
  ImGui::SetNextItemWidth(-1.0f);
  static constexpr double kSpeeds[] = {0.1, 0.25, 0.5, 1.0, 2.0, 4.0};
  std::snprintf(text, sizeof text, "%gx", model.speed);
  if (ImGui::BeginCombo("##speed", text)) {
    for (const double speed : kSpeeds) {
      std::snprintf(text, sizeof text, "%gx", speed);
      if (ImGui::Selectable(text, speed == model.speed)) context.actions.setSpeed = speed;
    }
    ImGui::EndCombo();
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

void drawHelp(const PanelContext& context) {
  struct Key {
    const char* keys;
    const char* what;
  };
  static constexpr Key kKeys[] = {
      {nullptr, "Safety"},
      {"Space", "zero force, on and off (Ctrl + Space while typing)"},
      {"C", "clear a fault: force comes back, rising slowly"},
      {nullptr, "Camera"},
      {"Right or middle drag", "turn about the point under the mouse"},
      {"Shift + drag", "shift"},
      {"Wheel", "zoom towards the mouse"},
      {"F", "fit the selected part, or everything"},
      {"Home", "fit everything"},
      {"1  3  7", "front, right, top"},
      {nullptr, "Stylus without a device"},
      {"Mouse", "moves the tip; it waits just before surfaces"},
      {"W  S,  Ctrl + wheel", "push in, pull back"},
      {"Q  E,  arrow keys", "turn"},
      {"Left button", "hold the part under the cursor while pressed"},
      {"G", "hold until pressed again"},
      {nullptr, "With a device"},
      {"Left drag, left click", "turn the camera, select"},
      {nullptr, "Parts"},
      {"Right click", "select; menu"},
      {"H   Shift + H", "hide the selected part, show all"},
      {"I", "show the selected part alone"},
      {"T", "transparent"},
      {"Esc", "select nothing, no clash, stop following"},
      {"X, held", "point: the others see the place under the mouse"},
      {nullptr, "Notes and measures"},
      {"N", "write a note at the place under the mouse"},
      {"Ctrl + Z   Ctrl + Y", "undo, redo what you wrote"},
      {"B", "back from where a note led"},
      {"M", "measure the place under the mouse, or between two"},
      {nullptr, "Window"},
      {"Tab", "panels on and off"},
      {"P", "play or pause a recording"},
      {"F1", "this help"},
  };
  const ImVec2 window = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * window.x, 0.5f * window.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 8.0f);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(24.0f * context.scale, 18.0f * context.scale));
  ImGui::PushStyleColor(ImGuiCol_WindowBg, theme::kRaised);
  ImGui::SetNextWindowFocus();
  ImGui::Begin("##help", nullptr, kFixed | ImGuiWindowFlags_AlwaysAutoResize);
  for (const Key& key : kKeys) {
    if (!key.keys) {
      ImGui::Spacing();
      heading(context, key.what);
      continue;
    }
    ImGui::TextColored(theme::kAccent, "%s", key.keys);
    ImGui::SameLine(190.0f * context.scale);
    ImGui::TextUnformatted(key.what);
  }
  ImGui::Spacing();
  if (ImGui::Button("Close")) context.ui.showHelp = false;
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
}

}  // namespace tandem::client
