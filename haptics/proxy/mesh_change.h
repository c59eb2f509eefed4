#pragma once

// The proxy when the triangles under it are exchanged: a mesh is deformed in place, tessellated anew, or
// gives way to another shape, while the tool may rest on it.
//
// 1. noteSides() while the triangles that the contacts name still exist; followMeshes() before anything else
// uses them.
// 2. Neither allocates; both are bounded: at most 2 rays, 2 sweeps and 65 nearest-point queries a contact; 6
// rays, a sweep and 33 queries for each of at most kMaxNearParts other parts.

#include <array>
#include <span>

#include "haptics/proxy/proxy.h"

namespace tandem::haptics {

/// A change that the proxy has not followed yet.
struct MeshChange {
  bool pending = false;
  std::array<bool, kMaxPlanes>
      front{};  // a plane of the proxy: whether it is touched from its triangle's front
};

/// Notes from which side the proxy touches its triangles.
void noteSides(const ContactWorld& world, const Proxy& proxy, MeshChange& change);

inline constexpr int kMaxNearParts = 16;  // beside those that the proxy touches

/// Parts that the proxy could not be kept out of.
struct FollowedMeshes {
  std::array<PartId, kMaxPlanes + kMaxNearParts> parts{};
  int count = 0;
  bool overflow = false;  // more parts were near; the proxy may be inside of others

  std::span<const PartId> squeezed() const { return {parts.data(), static_cast<std::size_t>(count)}; }
};

/// Puts the proxy outside the parts as they are now, on the side of each on which it was: out of a surface
/// that has come over it along the way in which its old contacts held it, or along the normal of one of them,
/// else by the nearest way; it stays where it is free. Its contacts then name triangles that exist. A part
/// that it could not be kept out of is ignored from then on (ContactWorld::setIgnored()) and returned.
FollowedMeshes followMeshes(ContactWorld& world, double radius, MeshChange& change, Proxy& proxy);

}  // namespace tandem::haptics
