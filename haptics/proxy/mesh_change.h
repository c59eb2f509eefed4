#pragma once

// Keeps the proxy outside when the triangles under it are exchanged: a mesh is deformed in place, tessellated
// anew or replaced while the tool may rest on it.
//
// 1. Call noteSides() while the triangles named by the contacts still exist, and followMeshes() before
//    anything else uses those contacts.
// 2. Neither function allocates. The work is bounded: at most 2 rays, 2 sweeps and 65 nearest-point queries
//    per contact, and 6 rays, a sweep and 33 queries for each of at most kMaxNearParts other parts.

#include <array>

#include "haptics/base/fixed_vector.h"
#include "haptics/proxy/proxy.h"

namespace tandem::haptics {

/// A mesh change that the proxy has not followed yet.
struct MeshChange {
  bool pending = false;
  // Whether each plane of the proxy is touched from the front of its triangle.
  std::array<bool, kMaxPlanes> front{};
};

/// Notes from which side the proxy touches its triangles.
void noteSides(const ContactWorld& world, const Proxy& proxy, MeshChange& change);

inline constexpr int kMaxNearParts = 16;  // parts near the proxy, besides those that it touches

/// Parts from which the proxy could not be freed.
struct FollowedMeshes {
  FixedVector<PartId, kMaxPlanes + kMaxNearParts> squeezed;
  bool overflow = false;  // more parts were near than fit; the proxy may be inside others
};

/// Puts the proxy outside the parts as they are now, on the side of each where it was. If a surface has
/// passed over the proxy, the proxy leaves along the direction in which its old contacts held it, or along
/// the normal of one of them, or else by the shortest path. A free proxy stays where it is. Afterwards its
/// contacts name triangles that exist. A part from which it could not be freed is returned, and is ignored
/// from then on (ContactWorld::setIgnored()).
FollowedMeshes followMeshes(ContactWorld& world, double radius, MeshChange& change, Proxy& proxy);

}  // namespace tandem::haptics
