#include "haptics/proxy/crease.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/base/fixed_vector.h"

namespace tandem::haptics {
namespace {

/// Calls visit(triangle, corners) for the triangles that meet at a contact, as far as the mesh knows its
/// neighbours.
template <typename Visit>
void forEachAround(const TriangleBvh& tree, std::uint32_t triangle, const glm::dvec3& q, double skin,
                   Visit&& visit) {
  ASSERT(triangle < tree.mesh().triangles.size());

  constexpr std::size_t kMaxAround = 24;
  const auto& neighbours = tree.mesh().neighbours;
  FixedVector<std::uint32_t, kMaxAround> around;
  around.push_back(triangle);
  for (std::size_t i = 0; i < around.size(); ++i) {
    const Triangle t = tree.triangle(around[i]);
    visit(around[i], t);
    if (around[i] >= neighbours.size()) continue;
    const glm::dvec3 corners[3] = {t.a, t.b, t.c};
    for (std::size_t e = 0; e < 3 && !around.full(); ++e) {
      const std::uint32_t next = neighbours[around[i]][e];
      if (next == assets::kNone) continue;
      const glm::dvec3 along = corners[(e + 1) % 3] - corners[e], off = q - corners[e];
      const double square = glm::dot(along, along);
      const double place = square > 0.0 ? std::clamp(glm::dot(off, along) / square, 0.0, 1.0) : 0.0;
      if (glm::length(off - place * along) > 2.0 * skin) continue;
      if (std::find(around.begin(), around.end(), next) == around.end()) around.push_back(next);
    }
  }
}

}  // namespace

Crease creaseUnder(const ContactWorld& world, const SurfacePoint& contact, double skin) {
  const CutFace corners = world.face(contact.part, contact.triangle);
  const glm::dvec3& q = contact.point;
  Crease nearest{q, q};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    if (glm::length(q - a) <= skin) return {a, a};
    const glm::dvec3 along = b - a;
    const double square = glm::dot(along, along);
    if (!(square > 0.0)) continue;
    const glm::dvec3 off = q - a - along * (glm::dot(q - a, along) / square);
    if (glm::dot(off, off) < least) {
      least = glm::dot(off, off);
      nearest = {a, b};
    }
  }
  return nearest;
}

double lengthAcross(const Crease& crease, const glm::dvec3& displacement) {
  const glm::dvec3 axis = crease.b - crease.a;
  const double square = glm::dot(axis, axis);
  return glm::length(square > 0.0 ? displacement - axis * (glm::dot(displacement, axis) / square)
                                  : displacement);
}

RollLimit rollLimit(const ContactWorld& world, const SurfacePoint& contact, double skin,
                    const glm::dvec3& tangent) {
  const Pose& pose = world.pose(contact.part);
  const glm::dquat partFromWorld = glm::conjugate(pose.orientation);
  const glm::dvec3 normal = partFromWorld * contact.normal, ahead = partFromWorld * tangent;
  const glm::dvec3 q = partFromWorld * (contact.point - pose.position);
  RollLimit limit;
  ASSERT(world.has(contact.part) && world.collider(contact.part).tree != nullptr);

  const TriangleBvh& tree = *world.collider(contact.part).tree;
  const Sections cut = world.sections().empty() ? Sections{} : world.sectionsOf(contact.part);
  forEachAround(tree, contact.triangle, q, skin, [&](std::uint32_t triangle, const Triangle& t) {
    for (const glm::dvec3& corner : cutTriangle(t, cut)) {
      const glm::dvec3 d = corner - q;
      const double forward = glm::dot(ahead, d);
      // A corner straight along the crease does not end the roll.
      if (glm::length(d) <= 2.0 * skin || forward <= 1e-6 * glm::length(d)) continue;
      const double angle = std::atan2(std::max(0.0, -glm::dot(normal, d)), forward);
      if (angle < limit.angle) limit = {angle, triangle};
    }
  });
  return limit;
}

}  // namespace tandem::haptics
