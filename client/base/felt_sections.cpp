#include "client/base/felt_sections.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::client {

haptics::Sections feltSections(std::span<const document::SectionPlane> planes) {
  haptics::Sections felt;
  for (const document::SectionPlane& plane : planes) {
    const double length = glm::length(plane.normal);
    if (!(length > 0.0) || !std::isfinite(length) || felt.full()) continue;
    const glm::dvec3 normal = plane.normal / length;
    const double offset = glm::dot(normal, plane.point);
    if (std::isfinite(offset)) felt.push_back({normal, offset});
  }
  return felt;
}

}  // namespace tandem::client
