#pragma once

// How far a path stays from the parts of a scene, asked of every triangle: a ball of that radius can go the
// same way in one continuous motion. Nothing here is used by the code under test.

#include <algorithm>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "assets/scene/scene.h"

namespace tandem::test {

/// Least distance of two segments, m (Ericson, "Real-Time Collision Detection", 5.1.9).
inline double segmentDistance(const glm::dvec3& p1, const glm::dvec3& q1, const glm::dvec3& p2,
                              const glm::dvec3& q2) {
  const glm::dvec3 d1 = q1 - p1, d2 = q2 - p2, r = p1 - p2;
  const double a = glm::dot(d1, d1), e = glm::dot(d2, d2), f = glm::dot(d2, r), c = glm::dot(d1, r);
  const auto share = [](double part, double whole) {
    return whole > 0.0 ? std::clamp(part / whole, 0.0, 1.0) : 0.0;
  };
  const double b = glm::dot(d1, d2);
  double s = share(b * f - c * e, a * e - b * b);
  const double t = share(b * s + f, e);
  s = share(b * t - c, a);
  return glm::length(p1 + d1 * s - p2 - d2 * t);
}

/// Whether the line of a segment passes through the inside of a triangle or p lies over it.
inline bool within(const glm::dvec3& p, const glm::dvec3& direction, const std::array<glm::dvec3, 3>& t) {
  const double u = glm::dot(direction, glm::cross(t[1] - p, t[0] - p));
  const double v = glm::dot(direction, glm::cross(t[2] - p, t[1] - p));
  const double w = glm::dot(direction, glm::cross(t[0] - p, t[2] - p));
  return (u <= 0.0 && v <= 0.0 && w <= 0.0) || (u >= 0.0 && v >= 0.0 && w >= 0.0);
}

/// Least distance of a segment to a triangle, m; 0 where it passes through.
inline double segmentDistance(const glm::dvec3& p, const glm::dvec3& q, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 area = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double twice = glm::length(area);
  const double hp = glm::dot(area, p - t[0]), hq = glm::dot(area, q - t[0]);
  double least = std::min({segmentDistance(p, q, t[0], t[1]), segmentDistance(p, q, t[1], t[2]),
                           segmentDistance(p, q, t[2], t[0])});
  if (!(twice > 0.0)) return least;
  if ((hp > 0.0) != (hq > 0.0) && within(p, q - p, t)) return 0.0;
  if (within(p, area, t)) least = std::min(least, std::abs(hp) / twice);
  if (within(q, area, t)) least = std::min(least, std::abs(hq) / twice);
  return least;
}

/// The parts of a scene at rest.
class PathClearance {
 public:
  explicit PathClearance(const assets::Scene& scene) : scene_(scene) {
    for (const assets::Mesh& mesh : scene.meshes) {
      boxes_.emplace_back();
      for (const auto& t : mesh.triangles) {
        const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        boxes_.back().push_back({glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))});
      }
    }
  }

  /// Whether a ball can go straight from p to q. Its radius is `share` of the largest coordinate of each
  /// part's mesh.
  bool ballPasses(const glm::dvec3& p, const glm::dvec3& q, double share) const {
    return std::all_of(scene_.parts.begin(), scene_.parts.end(), [&](const assets::Part& part) {
      if (part.mesh == assets::kNone) return true;
      const glm::dquat partFromWorld = glm::conjugate(part.worldFromPart.orientation);
      const glm::dvec3& origin = part.worldFromPart.position;
      return passes(part.mesh, partFromWorld * (p - origin), partFromWorld * (q - origin), share);
    });
  }

 private:
  static bool meets(const assets::Bounds& a, const assets::Bounds& b) {
    return glm::all(glm::lessThanEqual(a.min, b.max)) && glm::all(glm::lessThanEqual(b.min, a.max));
  }

  bool passes(std::uint32_t index, const glm::dvec3& p, const glm::dvec3& q, double share) const {
    const assets::Mesh& mesh = scene_.meshes[index];
    const glm::dvec3 most = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
    const double radius = share * std::max({most.x, most.y, most.z});
    const glm::dvec3 grow(radius);
    const assets::Bounds path{glm::min(p, q) - grow, glm::max(p, q) + grow};
    if (!meets(path, mesh.bounds)) return true;
    const auto& boxes = boxes_[index];
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (!meets(path, boxes[i])) continue;
      const auto& t = mesh.triangles[i];
      const std::array<glm::dvec3, 3> corners{mesh.positions[t[0]], mesh.positions[t[1]],
                                              mesh.positions[t[2]]};
      if (segmentDistance(p, q, corners) < radius) return false;
    }
    return true;
  }

  const assets::Scene& scene_;
  std::vector<std::vector<assets::Bounds>> boxes_;  // of the triangles of each mesh
};

}  // namespace tandem::test
