#include "client/marks/section_set.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include <glm/geometric.hpp>

namespace tandem::client {
namespace {

constexpr double kFarthest = 1e6;  // m

}  // namespace

SectionSet::SectionSet(std::span<const document::SectionPlane> planes) {
  for (const document::SectionPlane& plane : planes) {
    const double length = glm::length(plane.normal);
    if (!(length > 0.0) || !std::isfinite(length) || full()) continue;
    const glm::dvec3 normal = plane.normal / length;
    bool square = false;
    for (int axis = 0; axis < 3 && !square; ++axis) {
      if (std::abs(normal[axis]) < 1.0 - 1e-9) continue;
      std::optional<double>& place = (normal[axis] > 0.0 ? beyond : before)[static_cast<std::size_t>(axis)];
      square = !place;
      if (square) place = plane.point[axis];
    }
    if (!square) oblique.push_back({normal, glm::dot(normal, plane.point)});
  }
}

std::size_t SectionSet::count() const {
  std::size_t count = oblique.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (beyond[axis]) ++count;
    if (before[axis]) ++count;
  }
  return count;
}

std::vector<document::SectionPlane> SectionSet::planes() const {
  std::vector<document::SectionPlane> planes;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 along(0.0);
    along[axis] = 1.0;
    const auto index = static_cast<std::size_t>(axis);
    if (beyond[index]) planes.push_back({*beyond[index] * along, along});
    if (before[index]) planes.push_back({*before[index] * along, -along});
  }
  for (const ObliqueSection& section : oblique)
    planes.push_back({section.place * section.normal, section.normal});
  return planes;
}

void SectionSet::move(std::size_t index, double by) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (beyond[axis] && index-- == 0) {
      *beyond[axis] += by;
      return;
    }
    if (before[axis] && index-- == 0) {
      *before[axis] -= by;
      return;
    }
  }
  if (index < oblique.size()) oblique[index].place += by;
}

void SectionSet::turn(std::size_t index, const glm::dquat& rotation, const glm::dvec3& about) {
  const std::size_t square = count() - oblique.size();
  if (index < square || index >= count()) return;
  ObliqueSection& section = oblique[index - square];
  section.normal = glm::normalize(rotation * section.normal);
  section.place = glm::dot(section.normal, about);
}

Status SectionSet::add(const std::string& text) {
  if (full())
    return Error{text + ": there are " + std::to_string(document::kMaxSections) + " sections already"};
  if (text.find(',') != std::string::npos) return addOblique(text);
  const Error wrong{text +
                    ": not a section, as x=0.05, -x=0.05 (x, y or z; m) or 1,1,0,0.05 (a direction, m)"};
  std::string_view rest = text;
  const bool negative = rest.starts_with('-');
  if (negative) rest.remove_prefix(1);
  if (rest.size() < 3 || rest[0] < 'x' || rest[0] > 'z' || rest[1] != '=') return wrong;
  const auto axis = static_cast<std::size_t>(rest[0] - 'x');
  const char* number = rest.data() + 2;
  char* end = nullptr;
  const double at = std::strtod(number, &end);
  if (end == number || *end != '\0' || !(std::abs(at) <= kFarthest)) return wrong;
  std::optional<double>& position = negative ? before[axis] : beyond[axis];
  if (position) return Error{text + ": there is a section on this side already"};
  position = at;
  return {};
}

Status SectionSet::addOblique(const std::string& text) {
  glm::dvec3 normal(0.0);
  double place = 0.0;
  char rest = 0;
  const bool read =
      std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%c", &normal.x, &normal.y, &normal.z, &place, &rest) == 4;
  const double length = glm::length(normal);
  if (!read || !(length > 1e-9 && length < 1e9) || !(std::abs(place) <= kFarthest))
    return Error{text + ": not a section, as NX,NY,NZ,M: a direction, and how far along it (m)"};
  oblique.push_back({normal / length, place});
  return {};
}

Status SectionSet::addAll(const std::vector<std::string>& texts) {
  for (const std::string& text : texts)
    if (Status added = add(text); !added) return Error{"--section " + added.error().message};
  return {};
}

}  // namespace tandem::client
