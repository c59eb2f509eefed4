#include "haptics/scene/contact_patch.h"

#include <algorithm>

namespace tandem::haptics {
namespace {

/// Unit vector within `angle` of the unit vector `middle`, as near to the direction of `wanted` (any length)
/// as possible.
glm::dvec3 within(const glm::dvec3& middle, const glm::dvec3& wanted, double angle) {
  const double length = glm::length(wanted);
  if (!(length > 0.0)) return middle;
  const glm::dvec3 direction = wanted / length;
  const double cosine = glm::dot(direction, middle), least = std::cos(angle);
  if (cosine >= least) return direction;
  const glm::dvec3 aside = direction - cosine * middle;
  const double sine = glm::length(aside);
  if (!(sine > 1e-12)) return middle;
  return least * middle + (std::sin(angle) / sine) * aside;
}

}  // namespace

double ContactPatch::reach() const {
  const double chord = 2.0 * std::sin(0.5 * angle);
  switch (kind) {
    case Kind::cap:
    case Kind::rim:
      return radius * chord;
    case Kind::side:
      return along * (1.0 + std::abs(grow)) + (radius + along * std::abs(grow)) * chord;
    case Kind::straight:
      break;
  }
  return along;
}

glm::dvec3 ContactPatch::pointAt(const Place& place) const {
  switch (kind) {
    case Kind::cap:
    case Kind::rim:
      return centre + radius * place.out;
    case Kind::side: {
      const double across = std::sqrt(std::max(0.0, 1.0 - grow * grow));
      return centre + place.t * axis + (radius + place.t * grow) * (across * place.out - grow * axis);
    }
    case Kind::straight:
      break;
  }
  return centre + place.t * axis;
}

int ContactPatch::normalsAt(const Place& place, std::array<glm::dvec3, 2>& normals) const {
  if (kind == Kind::straight) return 0;
  normals[0] = place.out;
  if (kind == Kind::cap) return 1;
  normals[0] = std::sqrt(std::max(0.0, 1.0 - grow * grow)) * place.out - grow * axis;
  normals[1] = cap * place.out + std::sqrt(std::max(0.0, 1.0 - cap * cap)) * axis;
  return kind == Kind::rim ? 2 : 1;
}

glm::dvec3 ContactPatch::turned(const glm::dvec3& wanted, double slack) const {
  if (kind == Kind::cap) return within(out, wanted, angle);
  if (kind == Kind::straight) return out;
  glm::dvec3 across = wanted - axis * glm::dot(axis, wanted);
  if (radius > 0.0) across += (slack / radius) * out;
  return within(out, across, angle);
}

ContactPatch::Place ContactPatch::lowest(const glm::dvec3& up, double slack) const {
  Place place{turned(-up, slack), 0.0};
  if (!(along > 0.0)) return place;
  double slope = glm::dot(up, axis);
  if (kind == Kind::side) {
    const double across = std::sqrt(std::max(0.0, 1.0 - grow * grow));
    slope += grow * glm::dot(up, across * place.out - grow * axis);
  }
  const double drop = slope * along;
  place.t = -along * (slack > 0.0  ? std::clamp(drop / slack, -1.0, 1.0)
                      : drop > 0.0 ? 1.0
                      : drop < 0.0 ? -1.0
                                   : 0.0);
  return place;
}

ContactPatch::Place ContactPatch::nearestTo(const glm::dvec3& p) const {
  Place place{out, 0.0};
  if (kind == Kind::side || kind == Kind::straight) {
    const double height = glm::dot(axis, p - centre);
    const double distance = glm::length(p - centre - height * axis);
    const double lean =
        kind == Kind::side ? distance * grow / std::sqrt(std::max(1e-12, 1.0 - grow * grow)) : 0.0;
    place.t = std::clamp(height + lean, -along, along);
  }
  place.out = turned(p - (centre + place.t * axis), 0.0);
  return place;
}

}  // namespace tandem::haptics
