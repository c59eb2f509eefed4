#include "assets/gltf/part_mass.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtx/norm.hpp>
#include <glm/matrix.hpp>

#include "assets/base/constants.h"
#include "assets/gltf/gltf_physics.h"

namespace tandem::assets {
namespace {

constexpr double kInfiniteInertiaRatio = 1e6;

struct Solid {
  double mass = 0.0;
  glm::dvec3 inertia{0.0};  // principal, about the centre, shape axes
};

/// Textbook solids, axis along Y.
Solid cylinderSolid(double radius, double height, double density) {
  const double mass = kPi * radius * radius * height * density;
  const double side = mass * (3.0 * radius * radius + height * height) / 12.0;
  return {mass, {side, 0.5 * mass * radius * radius, side}};
}

Solid sphereSolid(double radius, double density) {
  const double mass = 4.0 / 3.0 * kPi * radius * radius * radius * density;
  return {mass, glm::dvec3(0.4 * mass * radius * radius)};
}

Solid solidOf(const ImplicitShape& shape, double density) {
  const double radius = 0.5 * (shape.radiusTop + shape.radiusBottom);
  switch (shape.kind) {
    case ImplicitShape::Kind::box: {
      const glm::dvec3 s = shape.size * shape.size;
      const double mass = shape.size.x * shape.size.y * shape.size.z * density;
      return {mass, mass / 12.0 * glm::dvec3(s.y + s.z, s.x + s.z, s.x + s.y)};
    }
    case ImplicitShape::Kind::sphere:
      return sphereSolid(shape.radiusBottom, density);
    case ImplicitShape::Kind::cylinder:
      return cylinderSolid(radius, shape.height, density);
    case ImplicitShape::Kind::capsule: {
      Solid solid = cylinderSolid(radius, shape.height, density);
      const Solid ball = sphereSolid(radius, density);
      // Half balls at both ends: their centres lie 3/8 r beyond the cylinder's ends.
      const double side = ball.mass * (0.4 * radius * radius + 0.25 * shape.height * shape.height +
                                       0.375 * shape.height * radius);
      solid.mass += ball.mass;
      solid.inertia += glm::dvec3(side, ball.inertia.y, side);
      return solid;
    }
    case ImplicitShape::Kind::plane:
      break;
  }
  return {};
}

glm::dmat3 diagonal(const glm::dvec3& d) {
  return {glm::dvec3(d.x, 0.0, 0.0), glm::dvec3(0.0, d.y, 0.0), glm::dvec3(0.0, 0.0, d.z)};
}

glm::dmat3 rotated(const glm::dquat& rotation, const glm::dvec3& principal) {
  const glm::dmat3 r = glm::mat3_cast(rotation);
  return r * diagonal(principal) * glm::transpose(r);
}

/// Inertia that a point mass at `arm` adds (Steiner).
glm::dmat3 steiner(double mass, const glm::dvec3& arm) {
  return mass * (diagonal(glm::dvec3(glm::dot(arm, arm))) - glm::outerProduct(arm, arm));
}

bool isUsable(double value) { return std::isfinite(value) && value > 0.0; }

}  // namespace

Bounds shapeBounds(const ImplicitShape& shape) {
  const double radius = std::max(shape.radiusTop, shape.radiusBottom);
  glm::dvec3 half(0.5 * shape.size);
  if (shape.kind == ImplicitShape::Kind::sphere) half = glm::dvec3(shape.radiusBottom);
  if (shape.kind == ImplicitShape::Kind::cylinder) half = {radius, 0.5 * shape.height, radius};
  if (shape.kind == ImplicitShape::Kind::capsule) half = {radius, 0.5 * shape.height + radius, radius};
  Bounds bounds;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 sign((corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0,
                          (corner & 4) != 0 ? 1.0 : -1.0);
    const glm::dvec3 point = transformPoint(shape.partFromShape, sign * half);
    bounds.include(point);
  }
  return bounds;
}

MassProperties shapesMass(const std::vector<ImplicitShape>& shapes, double density) {
  MassProperties total;
  glm::dvec3 moment(0.0);
  for (const ImplicitShape& shape : shapes) {
    const double mass = solidOf(shape, density).mass;
    total.mass += mass;
    moment += mass * shape.partFromShape.position;
  }
  if (!isUsable(total.mass)) return {};
  total.centreOfMass = moment / total.mass;
  for (const ImplicitShape& shape : shapes) {
    const Solid solid = solidOf(shape, density);
    total.inertia += rotated(shape.partFromShape.orientation, solid.inertia) +
                     steiner(solid.mass, shape.partFromShape.position - total.centreOfMass);
  }
  return total;
}

std::optional<MassProperties> usableMass(const MassProperties& computed) {
  const glm::dmat3& inertia = computed.inertia;
  const double determinant = glm::determinant(inertia);
  const bool good = isUsable(computed.mass) && isUsable(inertia[0][0]) && isUsable(inertia[1][1]) &&
                    isUsable(inertia[2][2]) && std::isfinite(determinant) &&
                    std::isfinite(glm::length2(computed.centreOfMass));
  if (!good) return std::nullopt;
  return computed;
}

std::optional<MassProperties> statedMass(const PhysicsMotion& motion, const MassProperties& computed,
                                         double unitScale) {
  MassProperties out = computed;
  if (motion.mass && *motion.mass > 0.0) {
    const double ratio = isUsable(computed.mass) ? *motion.mass / computed.mass : 0.0;
    out.mass = *motion.mass;
    out.inertia = computed.inertia * ratio;
  }
  if (motion.centreOfMass) out.centreOfMass = *motion.centreOfMass * unitScale;
  if (motion.inertiaDiagonal) {
    glm::dvec3 principal = *motion.inertiaDiagonal * (unitScale * unitScale);
    const double largest = std::max({principal.x, principal.y, principal.z});
    if (largest > 0.0) {
      for (int i = 0; i < 3; ++i)
        if (principal[i] == 0.0) principal[i] = kInfiniteInertiaRatio * largest;
      out.inertia = rotated(motion.inertiaOrientation, principal);
    }
  }
  return usableMass(out);
}

}  // namespace tandem::assets
