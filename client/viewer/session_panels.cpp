#include <imgui.h>

#include <algorithm>
#include <cstdio>

#include "assets/scene/stated_tolerances.h"
#include "client/picture/colours.h"
#include "client/session/doubt_words.h"
#include "client/session/holding_words.h"
#include "client/viewer/panels.h"
#include "client/viewer/strip_chart.h"

namespace tandem::client {
namespace {

const char* roleName(sync::Role role) {
  switch (role) {
    case sync::Role::observer:
      return "observer";
    case sync::Role::participant:
      return "participant";
    case sync::Role::instructor:
      return "instructor";
  }
  return "";
}

template <typename... Args>
std::string format(const char* pattern, Args... args) {
  char text[128];
  std::snprintf(text, sizeof text, pattern, args...);
  return text;
}

/// Draws text that wraps at the panel's edge.
void wrapped(const ImVec4& colour, const std::string& text) {
  ImGui::PushTextWrapPos(0.0f);
  ImGui::TextColored(colour, "%s", text.c_str());
  ImGui::PopTextWrapPos();
}

constexpr float kGap = 8.0f;  // pixels at least between a name and its value

/// A muted name at the left and a value at the right of one line; a long value stands below its name.
void valueLine(const char* name, const std::string& value, const ImVec4& colour = theme::kText) {
  const float width = ImGui::CalcTextSize(value.c_str()).x, right = ImGui::GetContentRegionMax().x;
  ImGui::TextColored(theme::kMuted, "%s", name);
  const bool fits = ImGui::GetCursorStartPos().x + ImGui::GetItemRectSize().x + kGap + width <= right;
  if (fits) {
    ImGui::SameLine(right - width);
    ImGui::TextColored(colour, "%s", value.c_str());
  } else {
    wrapped(colour, value);
  }
}

void drawPerson(const PanelContext& context, const SiteView& site) {
  ImGui::PushID(site.info.site);
  colourDot(srgb(site.info.colour), !site.info.connected);
  ImGui::SameLine();
  ImGui::PushFont(context.fonts.strong);
  ImGui::TextUnformatted(site.info.name.c_str());
  ImGui::PopFont();
  ImGui::SameLine();
  ImGui::TextColored(theme::kMuted, site.self ? "you, %s" : "%s", roleName(site.info.role));
  if (!site.self && site.seen && site.info.connected) {
    const bool follows = context.ui.following == site.info.site;
    const char* text = follows ? "Stop" : "Follow";
    ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(text).x -
                    2.0f * ImGui::GetStyle().FramePadding.x);
    if (ImGui::SmallButton(text)) context.ui.following = follows ? kNoSite : site.info.site;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("See what %s sees", site.info.name.c_str());
  }
  ImGui::Indent(22.0f * context.scale);
  std::string line = activityOf(context.model, site);
  const double force = glm::length(site.self ? context.model.hand.force : site.presence.force);
  if (site.info.connected && force > 0.02) line += format("  ·  %.2f N", force);
  wrapped(site.info.connected ? theme::kMuted : theme::kWarning, line);
  if (const std::string doubts = doubtsInWords(context.model, site); !doubts.empty())
    wrapped(theme::kWarning, doubts);
  ImGui::Unindent(22.0f * context.scale);
  ImGui::PopID();
}

/// Draws the distance between the held part and its nearest neighbour.
void drawNearest(const ViewModel& model) {
  const NearestView& nearest = model.hand.nearest;
  if (model.hand.held == kNoPart || nearest.part == kNoPart) return;
  valueLine("Nearest", partName(model, nearest.part));
  if (nearest.clearance > 0.0)
    valueLine("Clearance", format("%.3f mm", 1e3 * nearest.clearance));
  else if (nearest.clearance < 0.0)
    valueLine("Overlap", format("%.3f mm", -1e3 * nearest.clearance), theme::kWarning);
  else
    valueLine("Clearance", "touches", theme::kGood);
}

struct FlagText {
  std::uint32_t flag;
  const char* text;
  bool bad;
};
constexpr FlagText kFlagTexts[] = {
    {haptics::kFlagFault, "stopped by a fault: force is off", true},
    {haptics::kFlagStaleSample, "the device's readings stand still", true},
    {haptics::kFlagSampleJump, "the device's reading jumped", true},
    {haptics::kFlagInvalidSample, "no reading from the device", true},
    {haptics::kFlagForceLimited, "force is at its limit", false},
    {haptics::kFlagSlewLimited, "force is rising at its limit", false},
    {haptics::kFlagOverflow, "more contacts than can be felt at once", false},
    {haptics::kFlagSqueezed, "squeezed: no way out of everything", false},
    {haptics::kFlagHeldWithoutContact, "the held part passes through others", false},
    {haptics::kFlagProxyReset, "the tool was put back onto the hand", false},
    {haptics::kFlagInside, "inside a part: not felt until the tool has left it", false},
    {haptics::kFlagPopThrough, "a surface gave way: it is passed through", false},
    {haptics::kFlagFieldLimited, "a force field is at its maximum", false},
    {haptics::kFlagLessEffort, "contact goes more slowly: this machine is short of time", false},
};

void drawFlags(const PanelContext& context) {
  for (const FlagText& entry : kFlagTexts)
    if (context.model.hand.flags & entry.flag) {
      wrapped(entry.bad ? theme::kBad : theme::kWarning, std::string("\xE2\x97\x8F ") + entry.text);
    }
  if (!context.model.hand.fault.empty()) ImGui::TextWrapped("broken: %s", context.model.hand.fault.c_str());
  if (hasFault(context.model) && !context.model.replay && ImGui::Button("Clear the fault  (C)"))
    context.actions.resetFault = true;
}

void drawLoop(const PanelContext& context) {
  const LoopView& loop = context.model.loop;
  StripChart chart;
  chart.id = "loop";
  chart.title = "Tick";
  chart.now = loop.ticks == 0 ? "-"
                              : format("p50 %.0f  p99 %.0f  max %.0f µs", loop.compute_us_p50,
                                       loop.compute_us_p99, loop.compute_us_max);
  chart.limit = 1000.0f;
  chart.limitLabel = "1 ms";
  chart.minimumRange = 20.0f;
  chart.colour = theme::kGood;
  drawStripChart(chart, loop.recentCompute_us, 56.0f * context.scale, context.fonts.small);
  const double lateShare =
      loop.ticks > 0 ? 100.0 * static_cast<double>(loop.late) / static_cast<double>(loop.ticks) : 0.0;
  valueLine("Late ticks",
            loop.ticks == 0 ? "-"
                            : format("%llu of %llu (%.2f %%)", static_cast<unsigned long long>(loop.late),
                                     static_cast<unsigned long long>(loop.ticks), lateShare),
            lateShare > 1.0 ? theme::kWarning : theme::kText);
  valueLine("Real-time priority", loop.realtime ? "yes" : "no",
            loop.realtime ? theme::kGood : theme::kWarning);
}

}  // namespace

void colourDot(const glm::vec3& srgb, bool hollow) {
  const float size = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 centre(at.x + 0.5f * size, at.y + 0.55f * size);
  const ImU32 colour = theme::packed(theme::colour(srgb));
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (hollow) {
    list.AddCircle(centre, 0.32f * size, colour, 0, 1.5f);
  } else {
    list.AddCircleFilled(centre, 0.36f * size, colour);
  }
  ImGui::Dummy(ImVec2(size, size));
}

bool numberSlider(const PanelContext& context, const char* id, float& value, const SliderRange& range) {
  const float room = 74.0f * context.scale;
  ImGui::SetNextItemWidth(-room);
  const bool edited =
      ImGui::SliderFloat(id, &value, range.min, range.max, "", range.flags | ImGuiSliderFlags_AlwaysClamp);
  const std::string text = format(range.pattern, static_cast<double>(value));
  ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(text.c_str()).x);
  ImGui::TextUnformatted(text.c_str());
  return edited;
}

std::string activityOf(const ViewModel& model, const SiteView& site) {
  if (!site.info.connected) return "away";
  if (const std::string holding = holdingInWords(model, site); !holding.empty()) return holding;
  const PartId touched = site.self ? model.hand.touched : site.presence.touched;
  const bool feels = glm::length(site.self ? model.hand.force : site.presence.force) > 0.02;
  if (touched != kNoPart && feels) return "touches " + partName(model, touched);
  if (site.info.role == sync::Role::observer) return "watches";
  return site.self || site.seen ? "here" : "joining";
}

/// Where people talk, to be copied whole.
void drawVoice(const std::string& url) {
  if (url.empty()) return;
  const float button = ImGui::CalcTextSize("Copy").x + 4.0f * ImGui::GetStyle().FramePadding.x;
  ImGui::TextColored(theme::kMuted, "Voice");
  ImGui::SameLine();
  const std::string shown = shortenedTo(url, ImGui::GetContentRegionAvail().x - button);
  ImGui::TextUnformatted(shown.c_str());
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", url.c_str());
  ImGui::SameLine();
  if (ImGui::SmallButton("Copy##voice")) ImGui::SetClipboardText(url.c_str());
}

void drawPeople(const PanelContext& context) {
  if (context.model.sites.empty()) ImGui::TextDisabled("Nobody else: this is a local scene");
  for (const SiteView& site : context.model.sites) drawPerson(context, site);
  drawVoice(context.model.connection.voiceUrl);
  drawSharing(context);
}

void drawHand(const PanelContext& context) {
  const ViewModel& model = context.model;
  const HandView& hand = model.hand;
  if (!hand.present) {
    ImGui::TextDisabled("No device");
    return;
  }
  valueLine("Device", hand.deviceName, hand.valid ? theme::kText : theme::kBad);
  std::string part = hand.held != kNoPart ? partName(model, hand.held) : partName(model, hand.touched);
  const char* verb = hand.held != kNoPart ? "Holds" : hand.grabPending ? "Asks for" : "At";
  valueLine(verb, part.empty() ? "\xE2\x80\x93" : part);
  if (const std::string shared = sharingInWords(model); !shared.empty()) valueLine("Shared", shared);
  drawNearest(model);
  StripChart chart;
  chart.id = "force";
  chart.title = "Force";
  chart.now = format("%.2f N", glm::length(hand.force));
  chart.limit = static_cast<float>(model.settings.forceLimit);
  chart.limitLabel = format("limit %.1f N", model.settings.forceLimit);
  chart.minimumRange = static_cast<float>(model.settings.forceLimit) * 1.05f;
  chart.colour = theme::kAccent;
  drawStripChart(chart, model.loop.recentForce_n, 72.0f * context.scale, context.fonts.small);
  drawLoop(context);
  drawFlags(context);
}

void drawTolerances(const PanelContext& context) {
  const assets::Scene& scene = *context.model.scene;
  const PartId part = context.ui.parts.selected;
  wrapped(theme::kMuted, scene.parts[part].name);
  for (const std::string& words : assets::statedTolerances(scene, part)) wrapped(theme::kText, words);
}

void drawNetwork(const PanelContext& context) {
  const ConnectionView& connection = context.model.connection;
  valueLine("State", connection.status, connection.connected ? theme::kGood : theme::kWarning);
  if (!connection.connected) return;
  const auto lossColour = [](double loss) {
    return loss > 0.05 ? theme::kBad : loss > 0.01 ? theme::kWarning : theme::kText;
  };
  const auto known = [&](const std::string& figure) {
    return connection.roundTrip_ms > 0.0 ? figure : std::string("-");
  };
  valueLine("Round trip", known(format("%.1f ms", connection.roundTrip_ms)));
  valueLine("Play-out delay", known(format("%.1f ms", connection.playOut_ms)));
  valueLine("Lost on the way up", known(format("%.1f %%", 100.0 * connection.lossUp)),
            lossColour(connection.lossUp));
  valueLine("Lost on the way down", known(format("%.1f %%", 100.0 * connection.lossDown)),
            lossColour(connection.lossDown));
  valueLine("Sent", format("%.0f kbit/s", connection.sentKbit_s));
  valueLine("Received", format("%.0f kbit/s", connection.receivedKbit_s));
  valueLine("States travel over", connection.stateOverUdp ? "UDP" : "TLS (UDP is blocked)",
            connection.stateOverUdp ? theme::kText : theme::kWarning);
}

void drawSettings(const PanelContext& context) {
  HandSettings& settings = context.actions.settings;
  const HandSettings before = settings;
  const auto slider = [&](const char* name, const char* id, double& value, float min, float max,
                          const char* pattern, ImGuiSliderFlags flags) {
    auto edited = static_cast<float>(value);
    ImGui::AlignTextToFramePadding();
    ImGui::TextColored(theme::kMuted, "%s", name);
    ImGui::SameLine(108.0f * context.scale);
    if (numberSlider(context, id, edited, {min, max, pattern, flags})) value = static_cast<double>(edited);
  };
  if (!context.model.replay) {
    slider("Force limit", "##limit", settings.forceLimit, 0.2f, 12.0f, "%.1f N", 0);
    slider("Gain", "##gain", settings.gain, 0.0f, 1.0f, "%.2f", 0);
    slider("Stiffness", "##stiffness", settings.stiffness, 50.0f, 5000.0f, "%.0f N/m",
           ImGuiSliderFlags_Logarithmic);
    if (const double stiffest = context.model.hand.stiffest; stiffest > 0.0)
      valueLine("Stable on this device",
                settings.stiffness > stiffest ? format("only up to %.0f N/m", stiffest)
                                              : format("up to %.0f N/m", stiffest),
                settings.stiffness > stiffest ? theme::kWarning : theme::kGood);
    if (settings.forceLimit != before.forceLimit || settings.gain != before.gain ||
        settings.stiffness != before.stiffness)
      context.actions.settingsChanged = true;
    ImGui::Checkbox("Stylus follows surfaces", &context.ui.followSurface);
  }
  ImGui::Checkbox("Edges", &context.ui.showEdges);
  document::PartStyle& style = context.ui.parts.style;
  ImGui::BeginDisabled(context.ui.shared.following().followsView());
  ImGui::Checkbox("Hidden parts as ghosts", &style.ghosts);
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(theme::kMuted, "Colours");
  ImGui::SameLine(108.0f * context.scale);
  ImGui::SetNextItemWidth(-1.0f);
  const auto& names = document::kColouringNames;
  if (ImGui::BeginCombo("##colours", names[static_cast<std::size_t>(style.colouring)])) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto colouring = static_cast<PartColouring>(i);
      if (ImGui::Selectable(names[i], colouring == style.colouring)) style.colouring = colouring;
    }
    ImGui::EndCombo();
  }
  ImGui::EndDisabled();
}

}  // namespace tandem::client
