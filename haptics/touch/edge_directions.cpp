#include "haptics/touch/edge_directions.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/constants.h"

namespace tandem::haptics {
namespace {

constexpr double kAcross = 1e-3;  // cosine to the edge up to which a normal lies across it

/// The smallest arc that contains all directions added.
class Arc {
 public:
  explicit Arc(const EdgePlane& plane) : plane_(plane) {}
  /// Adds the direction opposite to v.
  void addOpposite(const glm::dvec3& v) {
    if (plane_.length(v) < 1e-6) return;
    const double a = plane_.angle(-v);
    low_ = std::min(low_, a);
    high_ = std::max(high_, a);
  }
  /// An arc of half a turn or more constrains nothing.
  bool known() const { return low_ <= high_ && high_ - low_ < kPi; }
  /// Of the edge's own directions.
  Directions ofEdge() const { return {std::max(0.0, low_), std::min(plane_.end(), high_)}; }
  bool beyondEnd() const { return low_ > plane_.end(); }

 private:
  const EdgePlane& plane_;
  double low_ = 1e300, high_ = -1e300;
};

}  // namespace

EdgePlane::EdgePlane(const MeshEdge& edge)
    : along_(glm::normalize(edge.b - edge.a)),
      first_(edge.normals[0]),
      second_(glm::cross(along_, first_)),
      end_(edge.angle) {}

double EdgePlane::angle(const glm::dvec3& v) const {
  double a = std::atan2(glm::dot(v, second_), glm::dot(v, first_));
  if (a > 0.5 * end_ + kPi) a -= 2.0 * kPi;
  if (a < 0.5 * end_ - kPi) a += 2.0 * kPi;
  return a;
}

double EdgePlane::length(const glm::dvec3& v) const {
  return std::hypot(glm::dot(v, second_), glm::dot(v, first_));
}

glm::dvec3 EdgePlane::direction(double angle) const {
  return std::cos(angle) * first_ + std::sin(angle) * second_;
}

Directions commonDirections(const EdgePlane& plane, std::span<const glm::dvec3> normals) {
  Arc arc(plane);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const double own = glm::dot(normals[i], plane.along());
    if (std::abs(own) <= kAcross) arc.addOpposite(normals[i]);
    for (std::size_t k = 0; k < i; ++k) {
      const double other = glm::dot(normals[k], plane.along());
      if (own * other < 0.0) arc.addOpposite(std::abs(other) * normals[i] + std::abs(own) * normals[k]);
    }
  }
  return arc.known() ? arc.ofEdge() : Directions{};
}

Directions nearestDirections(const EdgePlane& plane, std::span<const glm::dvec3> normals) {
  Arc arc(plane);
  for (const glm::dvec3& normal : normals) arc.addOpposite(normal);
  if (!arc.known()) return {0.0, plane.end()};
  const Directions within = arc.ofEdge();
  if (!within.none()) return within;
  return arc.beyondEnd() ? Directions{plane.end(), plane.end()} : Directions{0.0, 0.0};
}

glm::dvec3 partingDirection(const EdgePlane& plane, const Directions& shared, const glm::dvec3& offset,
                            const glm::dvec3& predicted, double slack) {
  double a = std::clamp(plane.angle(predicted), shared.low, shared.high);
  const double length = plane.length(offset);
  if (length > slack) {
    const double now = plane.angle(offset), limit = std::acos(-slack / length) - 1e-3;
    a = std::clamp(std::clamp(a, now - limit, now + limit), shared.low, shared.high);
  }
  return plane.direction(a);
}

}  // namespace tandem::haptics
