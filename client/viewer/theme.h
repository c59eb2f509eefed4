#pragma once

// How the panels look: colours, spacing, fonts. ImGui's context is current.

#include <imgui.h>

#include <glm/vec3.hpp>

#include "client/picture/scene_renderer.h"

namespace tandem::client {

struct Fonts {
  ImFont* text = nullptr;
  ImFont* strong = nullptr;
  ImFont* small = nullptr;
};

namespace theme {

inline const ImVec4 kText(0.13f, 0.15f, 0.18f, 1.0f);
inline const ImVec4 kMuted(0.42f, 0.46f, 0.51f, 1.0f);
inline const ImVec4 kPanel(0.965f, 0.970f, 0.976f, 1.0f);
inline const ImVec4 kRaised(1.0f, 1.0f, 1.0f, 1.0f);
inline const ImVec4 kLine(0.84f, 0.86f, 0.88f, 1.0f);
inline const ImVec4 kAccent(0.16f, 0.42f, 0.82f, 1.0f);
inline const ImVec4 kGood(0.10f, 0.55f, 0.29f, 1.0f);
inline const ImVec4 kWarning(0.80f, 0.47f, 0.02f, 1.0f);
inline const ImVec4 kBad(0.80f, 0.16f, 0.13f, 1.0f);

inline const Background kBackground{glm::vec3(0.74f, 0.79f, 0.84f), glm::vec3(0.93f, 0.94f, 0.95f)};

/// Loads fonts at this scale (DejaVu if it is installed, else ImGui's own) and sets colours and spacing.
Fonts apply(float scale);

inline ImVec4 colour(const glm::vec3& srgb, float alpha = 1.0f) { return {srgb.x, srgb.y, srgb.z, alpha}; }
inline ImU32 packed(const ImVec4& c, float alpha = 1.0f) {
  return ImGui::ColorConvertFloat4ToU32({c.x, c.y, c.z, c.w * alpha});
}

}  // namespace theme
}  // namespace tandem::client
