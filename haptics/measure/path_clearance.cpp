#include "haptics/measure/path_clearance.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace tandem::haptics {
namespace {

/// Least distance of two segments, m (Ericson, "Real-Time Collision Detection", 5.1.9).
double segmentDistance(const glm::dvec3& p1, const glm::dvec3& q1, const glm::dvec3& p2,
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
bool isOverTriangle(const glm::dvec3& p, const glm::dvec3& direction, const std::array<glm::dvec3, 3>& t) {
  const double u = glm::dot(direction, glm::cross(t[1] - p, t[0] - p));
  const double v = glm::dot(direction, glm::cross(t[2] - p, t[1] - p));
  const double w = glm::dot(direction, glm::cross(t[0] - p, t[2] - p));
  return (u <= 0.0 && v <= 0.0 && w <= 0.0) || (u >= 0.0 && v >= 0.0 && w >= 0.0);
}

/// Least distance of a segment to a triangle, m; 0 where it passes through.
double segmentDistance(const glm::dvec3& p, const glm::dvec3& q, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 area = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double twice = glm::length(area);
  const double hp = glm::dot(area, p - t[0]), hq = glm::dot(area, q - t[0]);
  double least = std::min({segmentDistance(p, q, t[0], t[1]), segmentDistance(p, q, t[1], t[2]),
                           segmentDistance(p, q, t[2], t[0])});
  if (!(twice > 0.0)) return least;
  if ((hp > 0.0) != (hq > 0.0) && isOverTriangle(p, q - p, t)) return 0.0;
  if (isOverTriangle(p, area, t)) least = std::min(least, std::abs(hp) / twice);
  if (isOverTriangle(q, area, t)) least = std::min(least, std::abs(hq) / twice);
  return least;
}

bool boxesMeet(const assets::Bounds& a, const assets::Bounds& b) {
  return glm::all(glm::lessThanEqual(a.min, b.max)) && glm::all(glm::lessThanEqual(b.min, a.max));
}

}  // namespace

PathClearance::PathClearance(const assets::Scene& scene) : scene_(scene) {
  for (const assets::Mesh& mesh : scene.meshes) {
    boxes_.emplace_back();
    for (const auto& t : mesh.triangles) {
      const glm::dvec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
      boxes_.back().push_back({glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))});
    }
  }
}

bool PathClearance::ballPasses(const glm::dvec3& p, const glm::dvec3& q, double share) const {
  return std::all_of(scene_.parts.begin(), scene_.parts.end(), [&](const assets::Part& part) {
    if (part.mesh == assets::kNone) return true;
    const glm::dquat partFromWorld = glm::conjugate(part.worldFromPart.orientation);
    const glm::dvec3& origin = part.worldFromPart.position;
    return passes(part.mesh, partFromWorld * (p - origin), partFromWorld * (q - origin), share);
  });
}

bool PathClearance::passes(std::uint32_t index, const glm::dvec3& p, const glm::dvec3& q,
                           double share) const {
  const assets::Mesh& mesh = scene_.meshes[index];
  const glm::dvec3 most = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
  const double radius = share * std::max({most.x, most.y, most.z});
  const glm::dvec3 grow(radius);
  const assets::Bounds path{glm::min(p, q) - grow, glm::max(p, q) + grow};
  if (!boxesMeet(path, mesh.bounds)) return true;
  const auto& boxes = boxes_[index];
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (!boxesMeet(path, boxes[i])) continue;
    const auto& t = mesh.triangles[i];
    const std::array<glm::dvec3, 3> corners{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
    if (segmentDistance(p, q, corners) < radius) return false;
  }
  return true;
}

}  // namespace tandem::haptics
