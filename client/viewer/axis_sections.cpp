#include "client/viewer/axis_sections.h"

#include <cmath>
#include <cstdlib>
#include <string_view>

namespace tandem::client {

bool AxisSections::any() const {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (beyond[axis] || before[axis]) return true;
  return false;
}

std::vector<document::SectionPlane> AxisSections::planes() const {
  std::vector<document::SectionPlane> planes;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 along(0.0);
    along[axis] = 1.0;
    const auto index = static_cast<std::size_t>(axis);
    if (beyond[index]) planes.push_back({*beyond[index] * along, along});
    if (before[index]) planes.push_back({*before[index] * along, -along});
  }
  return planes;
}

Status AxisSections::add(const std::string& text) {
  const Error wrong{text + ": not a section, as x=0.05 or -x=0.05 (x, y or z; m)"};
  std::string_view rest = text;
  const bool negative = rest.starts_with('-');
  if (negative) rest.remove_prefix(1);
  if (rest.size() < 3 || rest[0] < 'x' || rest[0] > 'z' || rest[1] != '=') return wrong;
  const auto axis = static_cast<std::size_t>(rest[0] - 'x');
  const char* number = rest.data() + 2;
  char* end = nullptr;
  const double at = std::strtod(number, &end);
  if (end == number || *end != '\0' || !(std::abs(at) <= 1e6)) return wrong;
  std::optional<double>& position = negative ? before[axis] : beyond[axis];
  if (position) return Error{text + ": there is a section on this side already"};
  position = at;
  return {};
}

}  // namespace tandem::client
