// The panel of section planes: a line for each side of each axis, with a switch and a place, and three for
// each plane of any direction.

#include <cmath>
#include <string>

#include <imgui.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "client/viewer/panels.h"
#include "client/viewer/theme.h"

namespace tandem::client {
namespace {

/// One plane: off, or at a place between `least` and `most`, m.
void drawPlane(const PanelContext& context, const char* name, const char* id, double least, double most,
               std::optional<double>& place) {
  bool on = place.has_value();
  ImGui::BeginDisabled(!on && context.ui.sections.full());
  const bool switched = ImGui::Checkbox(name, &on);
  ImGui::EndDisabled();
  if (switched) {
    if (on)
      place = 0.5 * (least + most);
    else
      place.reset();
  }
  if (!place) return;
  ImGui::SameLine(108.0f * context.scale);
  auto millimetres = static_cast<float>(1e3 * *place);
  const SliderRange range{static_cast<float>(1e3 * least), static_cast<float>(1e3 * most), "%.2f mm", 0};
  if (numberSlider(context, id, millimetres, range)) place = 1e-3 * static_cast<double>(millimetres);
}

/// A slider of an angle in degrees; true if the person moved it.
bool angleSlider(const PanelContext& context, const std::string& id, double& angle, float most) {
  auto degrees = static_cast<float>(glm::degrees(angle));
  if (!numberSlider(context, id.c_str(), degrees, {-most, most, "%.1f deg", 0})) return false;
  angle = glm::radians(static_cast<double>(degrees));
  return true;
}

/// A plane of any direction: its place along its normal from the middle of the scene, and where the normal
/// points, by the angle around z and the one up from x and y. A turn keeps the plane at the same place from
/// the middle. False if it shall go.
bool drawOblique(const PanelContext& context, const assets::Bounds& bounds, std::size_t index,
                 ObliqueSection& section) {
  const std::string id = std::to_string(index);
  const glm::dvec3 middle = 0.5 * (bounds.min + bounds.max);
  double from = section.place - glm::dot(section.normal, middle);  // m, from the middle
  ImGui::TextUnformatted(("Plane " + std::to_string(index + 1)).c_str());
  ImGui::SameLine(108.0f * context.scale);
  const bool flip = ImGui::SmallButton(("Flip##" + id).c_str());
  ImGui::SameLine();
  const bool remove = ImGui::SmallButton(("Remove##" + id).c_str());
  const auto reach = static_cast<float>(500.0 * glm::length(bounds.max - bounds.min));
  auto millimetres = static_cast<float>(1e3 * from);
  if (numberSlider(context, ("##place" + id).c_str(), millimetres, {-reach, reach, "%.2f mm", 0}))
    from = 1e-3 * static_cast<double>(millimetres);
  double around = std::atan2(section.normal.y, section.normal.x),
         up = std::asin(glm::clamp(section.normal.z, -1.0, 1.0));
  const bool turned = angleSlider(context, "##around" + id, around, 180.0f);
  if (angleSlider(context, "##up" + id, up, 89.9f) || turned)
    section.normal = {std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up)};
  if (flip) {
    section.normal = -section.normal;
    from = -from;
  }
  section.place = glm::dot(section.normal, middle) + from;
  return !remove;
}

void drawObliques(const PanelContext& context, const assets::Bounds& bounds) {
  SectionSet& sections = context.ui.sections;
  for (std::size_t i = 0; i < sections.oblique.size(); ++i) {
    if (!drawOblique(context, bounds, i, sections.oblique[i])) {
      sections.oblique.erase(sections.oblique.begin() + static_cast<std::ptrdiff_t>(i));
      return;  // the others move up in the next frame
    }
  }
  ImGui::BeginDisabled(sections.full());
  if (ImGui::SmallButton("Add a plane")) {
    const glm::dvec3 normal = glm::normalize(glm::dvec3(1.0, 1.0, 1.0));
    sections.oblique.push_back({normal, glm::dot(normal, 0.5 * (bounds.min + bounds.max))});
  }
  ImGui::EndDisabled();
}

}  // namespace

void drawSections(const PanelContext& context) {
  const bool followed = context.ui.shared.following().followsSections();
  if (followed) ImGui::TextColored(theme::kMuted, "Another's: your own come back after.");
  ImGui::BeginDisabled(followed);
  const assets::Bounds& bounds = context.model.scene->bounds;
  static constexpr const char* kBeyond[] = {"Beyond x", "Beyond y", "Beyond z"};
  static constexpr const char* kBefore[] = {"Before x", "Before y", "Before z"};
  static constexpr const char* kIds[] = {"##beyond x", "##beyond y", "##beyond z",
                                         "##before x", "##before y", "##before z"};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    SectionSet& sections = context.ui.sections;
    drawPlane(context, kBeyond[i], kIds[i], bounds.min[axis], bounds.max[axis], sections.beyond[i]);
    drawPlane(context, kBefore[i], kIds[i + 3], bounds.min[axis], bounds.max[axis], sections.before[i]);
  }
  drawObliques(context, bounds);
  ImGui::TextColored(theme::kMuted, "What is cut away is not felt.");
  if (context.ui.sections.any() && ImGui::SmallButton("All off")) context.ui.sections = {};
  ImGui::EndDisabled();
}

}  // namespace tandem::client
