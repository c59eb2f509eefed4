#pragma once

// The proxy when the triangles under it are exchanged: a mesh is deformed in place, tessellated anew, or
// gives way to another shape, while the tool may rest on it.
//
// 1. noteSides() while the triangles that the contacts name still exist; followMeshes() before anything else
// uses them.
// 2. Neither allocates; both are bounded: at most kMaxPlanes rays and some forty nearest-point queries a near
// part.

#include <array>

#include "haptics/proxy.h"

namespace tandem::haptics {

/// A change that the proxy has not followed yet.
struct MeshChange {
  bool pending = false;
  std::array<bool, kMaxPlanes>
      front{};  // a plane of the proxy: whether it is touched from its triangle's front
};

/// Notes from which side the proxy touches its triangles.
void noteSides(const ContactWorld& world, const Proxy& proxy, MeshChange& change);

/// Puts the proxy outside the parts as they are now, on the side of each on which it was: out of a surface
/// that has come over it along the way in which its old contacts held it, or along the normal of one of them,
/// else by the nearest way; it stays where it is free. Its contacts then name triangles that exist.
/// `squeezed(part)` is called for a part that it could not be kept out of.
template <typename Squeezed>
void followMeshes(const ContactWorld& world, double radius, MeshChange& change, Proxy& proxy,
                  Squeezed&& squeezed);

/// The way in which the contacts together hold the proxy off the device, unit; zero if none presses.
glm::dvec3 heldAlong(const Proxy& proxy);

/// Moves the proxy out of one part, by preference along `normal`, which may be zero. False if another part is
/// in the way or the tool fits nowhere near.
bool leavePart(const ContactWorld& world, PartId part, const glm::dvec3& normal, bool front, double radius,
               Proxy& proxy);

/// Finds the triangles that stand for the old contacts and drops contacts that are gone.
void renewPlanes(const ContactWorld& world, double radius, Proxy& proxy);

template <typename Squeezed>
void followMeshes(const ContactWorld& world, double radius, MeshChange& change, Proxy& proxy,
                  Squeezed&& squeezed) {
  change.pending = false;
  const glm::dvec3 held = heldAlong(proxy);
  for (int i = 0; i < proxy.planeCount; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const SurfacePoint& old = proxy.planes[index].surface;
    if (!world.touchable(old.part)) continue;
    const bool free =
        (held == glm::dvec3(0.0) || leavePart(world, old.part, held, change.front[index], radius, proxy)) &&
        leavePart(world, old.part, old.normal, change.front[index], radius, proxy);
    if (!free) squeezed(old.part);
  }
  const glm::dvec3 p = proxy.position, grow(radius);
  world.forEachNear({p - grow, p + grow}, [&](PartId part) {
    for (int i = 0; i < proxy.planeCount; ++i) {
      if (proxy.planes[static_cast<std::size_t>(i)].surface.part == part) return;
    }
    if (world.touchable(part) && !leavePart(world, part, glm::dvec3(0.0), true, radius, proxy))
      squeezed(part);
  });
  renewPlanes(world, radius, proxy);
}

}  // namespace tandem::haptics
