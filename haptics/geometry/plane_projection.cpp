#include "haptics/geometry/plane_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

class VertexSearch {
 public:
  VertexSearch(const glm::dvec3& goal, std::span<const HalfSpace> planes, double tolerance)
      : goal_(goal), planes_(planes), tolerance_(tolerance) {}

  Projection run() {
    const int count = static_cast<int>(planes_.size());
    if (tryPoint(goal_, {}, {})) return best_;
    for (int i = 0; i < count; ++i) {
      if (tryOne(i)) return best_;
    }
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) {
        if (tryTwo(i, j)) return best_;
      }
    }
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) {
        for (int k = j + 1; k < count; ++k) {
          if (tryThree(i, j, k)) return best_;
        }
      }
    }
    best_.exact = false;
    return best_;
  }

 private:
  /// How far the goal is behind a plane, m.
  double depth(int i) const { return planes_[i].offset - glm::dot(planes_[i].normal, goal_); }
  const glm::dvec3& normal(int i) const { return planes_[i].normal; }

  /// Keeps the candidate that violates the planes least; true if it violates none.
  bool tryPoint(const glm::dvec3& point, std::array<int, 3> active, std::array<double, 3> multiplier) {
    double worst = 0.0;
    for (const HalfSpace& plane : planes_) {
      worst = std::max(worst, plane.offset - glm::dot(plane.normal, point));
    }
    if (worst < least_) {
      least_ = worst;
      best_ = Projection{};
      best_.point = point;
      for (int i = 0; i < 3; ++i) {
        if (multiplier[i] > 0.0) best_.multiplier[static_cast<std::size_t>(active[i])] = multiplier[i];
      }
    }
    return worst <= tolerance_;
  }

  bool tryOne(int i) {
    const double m = depth(i);
    if (m < 0.0) return false;
    return tryPoint(goal_ + m * normal(i), {i}, {m});
  }

  bool tryTwo(int i, int j) {
    // Multipliers solve m_i + c m_j = d_i and c m_i + m_j = d_j.
    const double c = glm::dot(normal(i), normal(j));
    const double determinant = 1.0 - c * c;
    if (!(determinant > kSingular)) return false;
    const double di = depth(i), dj = depth(j);
    const double mi = (di - c * dj) / determinant, mj = (dj - c * di) / determinant;
    if (mi < 0.0 || mj < 0.0) return false;
    return tryPoint(goal_ + mi * normal(i) + mj * normal(j), {i, j}, {mi, mj});
  }

  bool tryThree(int i, int j, int k) {
    const glm::dvec3 &a = normal(i), &b = normal(j), &c = normal(k);
    const double volume = glm::dot(a, glm::cross(b, c));
    if (!(volume * volume > kSingular)) return false;
    const glm::dvec3 move =
        (depth(i) * glm::cross(b, c) + depth(j) * glm::cross(c, a) + depth(k) * glm::cross(a, b)) / volume;
    // Multipliers solve A m = move, with the normals as the columns of A: Cramer's rule.
    const double mi = glm::dot(move, glm::cross(b, c)) / volume;
    const double mj = glm::dot(move, glm::cross(c, a)) / volume;
    const double mk = glm::dot(move, glm::cross(a, b)) / volume;
    if (mi < 0.0 || mj < 0.0 || mk < 0.0) return false;
    return tryPoint(goal_ + move, {i, j, k}, {mi, mj, mk});
  }

  // Squared sine (or volume) of normals below which their intersection is lost to rounding: angles under 1e-6
  // rad.
  static constexpr double kSingular = 1e-12;

  const glm::dvec3& goal_;
  std::span<const HalfSpace> planes_;
  double tolerance_;
  double least_ = std::numeric_limits<double>::infinity();
  Projection best_;
};

}  // namespace

Projection projectOntoPlanes(const glm::dvec3& goal, std::span<const HalfSpace> planes, double tolerance) {
  ASSERT(planes.size() <= static_cast<std::size_t>(kMaxPlanes));
  return VertexSearch(goal, planes, tolerance).run();
}

}  // namespace tandem::haptics
