#include "client/viewer/theme.h"

#include <cmath>
#include <filesystem>

namespace tandem::client::theme {
namespace {

// Latin, Greek, Cyrillic, and the signs that the panels use: names of people and parts come in many
// languages.
constexpr ImWchar kGlyphs[] = {0x0020, 0x017F, 0x0370, 0x03FF, 0x0400, 0x04FF, 0x2010, 0x2044,
                               0x2190, 0x21FF, 0x2200, 0x22FF, 0x25A0, 0x25FF, 0};

ImFont* loadFont(const char* path, float pixels) {
  ImGuiIO& io = ImGui::GetIO();
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored))
    if (ImFont* font = io.Fonts->AddFontFromFileTTF(path, pixels, nullptr, kGlyphs)) return font;
  ImFontConfig config;
  config.SizePixels = std::floor(pixels);
  return io.Fonts->AddFontDefault(&config);
}

void setColours(ImGuiStyle& style) {
  ImGui::StyleColorsLight(&style);
  auto& c = style.Colors;
  const auto accent = [](float alpha) { return ImVec4(kAccent.x, kAccent.y, kAccent.z, alpha); };
  const auto ink = [](float alpha) { return ImVec4(0.10f, 0.16f, 0.26f, alpha); };
  c[ImGuiCol_Text] = kText;
  c[ImGuiCol_TextDisabled] = kMuted;
  c[ImGuiCol_WindowBg] = kPanel;
  c[ImGuiCol_ChildBg] = ImVec4(0, 0, 0, 0);
  c[ImGuiCol_PopupBg] = kRaised;
  c[ImGuiCol_Border] = c[ImGuiCol_Separator] = kLine;
  c[ImGuiCol_FrameBg] = kRaised;
  c[ImGuiCol_FrameBgHovered] = accent(0.10f);
  c[ImGuiCol_FrameBgActive] = accent(0.18f);
  c[ImGuiCol_Button] = ink(0.07f);
  c[ImGuiCol_ButtonHovered] = ink(0.13f);
  c[ImGuiCol_ButtonActive] = ink(0.20f);
  c[ImGuiCol_Header] = ink(0.055f);
  c[ImGuiCol_HeaderHovered] = ink(0.09f);
  c[ImGuiCol_HeaderActive] = ink(0.14f);
  c[ImGuiCol_CheckMark] = c[ImGuiCol_SliderGrabActive] = c[ImGuiCol_PlotLines] = accent(1.0f);
  c[ImGuiCol_SliderGrab] = accent(0.75f);
  c[ImGuiCol_ScrollbarBg] = ImVec4(0, 0, 0, 0);
  c[ImGuiCol_ScrollbarGrab] = ink(0.18f);
  c[ImGuiCol_ScrollbarGrabHovered] = ink(0.28f);
  c[ImGuiCol_ScrollbarGrabActive] = ink(0.36f);
}

}  // namespace

Fonts apply(float scale) {
  Fonts fonts;
  fonts.text = loadFont("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", std::round(14.0f * scale));
  fonts.strong = loadFont("/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf", std::round(14.0f * scale));
  fonts.small = loadFont("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", std::round(12.0f * scale));
  ImGuiStyle style;
  setColours(style);
  style.WindowPadding = ImVec2(12, 10);
  style.FramePadding = ImVec2(8, 4);
  style.ItemSpacing = ImVec2(8, 5);
  style.ItemInnerSpacing = ImVec2(6, 4);
  style.IndentSpacing = 16;
  style.ScrollbarSize = 10;
  style.GrabMinSize = 12;
  style.WindowRounding = 0;
  style.FrameRounding = style.GrabRounding = style.PopupRounding = 4;
  style.ScrollbarRounding = 5;
  style.WindowBorderSize = style.FrameBorderSize = 1;
  style.ScaleAllSizes(scale);
  ImGui::GetStyle() = style;
  return fonts;
}

}  // namespace tandem::client::theme
