#include "haptics/proxy/mesh_change.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

constexpr int kMaxSteps = 32;  // steps out of a corner; flat and convex surfaces take one

/// Unit normal of a triangle's front, world; zero where it has no area.
glm::dvec3 frontOf(const ContactWorld& world, PartId part, std::uint32_t triangle) {
  const glm::dvec3 n = areaVector(world.collider(part).tree->triangle(triangle));
  const double length = glm::length(n);
  return length > 0.0 ? transformVector(world.pose(part), n / length) : glm::dvec3(0.0);
}

/// Puts the point `rest` in front of the first triangle along the exit direction if that triangle is met from
/// behind, which means that the surface has passed over the point.
void putBefore(const ContactWorld& world, PartId part, const glm::dvec3& normal, bool front, double rest,
               glm::dvec3& p) {
  WorldHit hit;
  const Collider& collider = world.collider(part);
  const glm::dvec3 centre = transformPoint(world.pose(part), collider.centre);
  const double reach = glm::length(p - centre) + collider.radius;
  if (!world.sweepPart(part, p, normal * reach, 0.0, hit)) return;
  const glm::dvec3 face = frontOf(world, part, hit.triangle) * (front ? 1.0 : -1.0);
  if (glm::dot(face, normal) > 0.0) p = hit.point + face * rest;
}

/// Moves away from the nearest triangles until the tool is free of all of them.
bool clear(const ContactWorld& world, PartId part, double radius, glm::dvec3& p) {
  for (int step = 0; step < kMaxSteps; ++step) {
    const double margin = world.margin(part, p, radius), rest = radius + margin;
    SurfacePoint near;
    if (!world.nearest(part, p, rest, near) || near.distance >= radius + 0.5 * margin) return true;
    // Each step goes slightly further than the last, which leaves corners in few steps.
    p += near.normal * (rest - near.distance) * (1.0 + 0.02 * step);
  }
  return false;
}

/// Unit direction in which the contacts together press the proxy away from the device; zero if none presses.
glm::dvec3 pressingDirection(const Proxy& proxy) {
  glm::dvec3 sum(0.0);
  for (const ProxyPlane& plane : proxy.planes) {
    sum += plane.multiplier * plane.surface.normal;
  }
  const double length = glm::length(sum);
  return length > 0.0 ? sum / length : sum;
}

/// Moves the proxy out of one part, preferably along `normal`, which may be zero. False if another part is in
/// the way or the tool fits nowhere near.
bool leavePart(const ContactWorld& world, PartId part, const glm::dvec3& normal, bool front, double radius,
               Proxy& proxy) {
  glm::dvec3 p = proxy.position;
  const double rest = radius + world.margin(part, p, radius);
  if (normal != glm::dvec3(0.0)) {
    putBefore(world, part, normal, front, rest, p);
  } else if (world.encloses(part, p)) {
    SurfacePoint near;
    if (world.nearest(part, p, 2.0 * world.collider(part).radius, near)) p = near.point - near.normal * rest;
  }
  if (!clear(world, part, radius, p)) return false;
  if (p == proxy.position) return true;
  WorldHit obstacle;
  const glm::dvec3 displacement = p - proxy.position;
  if (!world.sweep(proxy.position, displacement, radius, part, obstacle)) {
    proxy.position = p;
    return true;
  }
  proxy.position += displacement * obstacle.t;
  return false;
}

/// Finds the triangles that replace those of the old contacts, and drops contacts that no longer exist.
void renewPlanes(const ContactWorld& world, double radius, Proxy& proxy) {
  FixedVector<ProxyPlane, kMaxPlanes> renewed;
  for (ProxyPlane plane : proxy.planes) {
    const PartId part = plane.surface.part;
    if (!world.touchable(part)) continue;
    // The search starts under the old contact, so that of two walls the right one is found.
    const double rest = radius + world.margin(part, proxy.position, radius);
    const glm::dvec3 foot = proxy.position - plane.surface.normal * rest;
    SurfacePoint found;
    if (!world.nearest(part, foot, rest, found)) continue;
    plane.surface = world.surfaceAt(part, found.triangle, proxy.position);
    plane.skin = world.skin(part, proxy.position);
    plane.margin = world.margin(part, proxy.position, radius);
    plane.arriving = false;
    const bool known = std::any_of(renewed.begin(), renewed.end(), [&](const ProxyPlane& other) {
      return other.surface.part == part && other.surface.triangle == found.triangle;
    });
    if (!known) renewed.push_back(plane);
  }
  proxy.planes = renewed;
}

/// Lists touchable parts near the proxy that none of its contacts names. The list is complete before
/// leavePart() runs, because leavePart() itself queries near parts.
FixedVector<PartId, kMaxNearParts> listNear(const ContactWorld& world, double radius, const Proxy& proxy,
                                            bool& overflow) {
  FixedVector<PartId, kMaxNearParts> near;
  const glm::dvec3 p = proxy.position, grow(radius);
  world.forEachNear({p - grow, p + grow}, [&](PartId part) {
    if (!world.touchable(part)) return;
    for (const ProxyPlane& plane : proxy.planes) {
      if (plane.surface.part == part) return;
    }
    if (near.full()) {
      overflow = true;
    } else {
      near.push_back(part);
    }
  });
  return near;
}

}  // namespace

void noteSides(const ContactWorld& world, const Proxy& proxy, MeshChange& change) {
  for (std::size_t i = 0; i < proxy.planes.size(); ++i) {
    const SurfacePoint& at = proxy.planes[i].surface;
    change.front[i] = world.collider(at.part).tree == nullptr ||
                      glm::dot(frontOf(world, at.part, at.triangle), at.normal) >= 0.0;
  }
}

FollowedMeshes followMeshes(ContactWorld& world, double radius, MeshChange& change, Proxy& proxy) {
  change.pending = false;
  FollowedMeshes followed;
  const auto squeezedBy = [&](PartId part) {
    world.setIgnored(part, true);
    followed.squeezed.push_back(part);
  };
  const glm::dvec3 pressing = pressingDirection(proxy);
  for (std::size_t i = 0; i < proxy.planes.size(); ++i) {
    const SurfacePoint& old = proxy.planes[i].surface;
    if (!world.touchable(old.part)) continue;
    const bool free = (pressing == glm::dvec3(0.0) ||
                       leavePart(world, old.part, pressing, change.front[i], radius, proxy)) &&
                      leavePart(world, old.part, old.normal, change.front[i], radius, proxy);
    if (!free) squeezedBy(old.part);
  }
  for (const PartId part : listNear(world, radius, proxy, followed.overflow)) {
    if (!leavePart(world, part, glm::dvec3(0.0), true, radius, proxy)) squeezedBy(part);
  }

  renewPlanes(world, radius, proxy);
  return followed;
}

}  // namespace tandem::haptics
