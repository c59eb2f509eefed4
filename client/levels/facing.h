#pragma once

// Whether the faces of a mesh all look away from what the mesh encloses, so that from outside no back of a
// face is seen.

#include "client/levels/render_mesh.h"

namespace tandem::client {

/// Whether `exact` is closed, and no ray along an axis comes to where it has left `level`, which is drawn in
/// its place, more often than it has entered it: there the mesh would be inside out. Rays stand 1/256 of the
/// mesh apart, so that what is inside out is no wider than that. O(T).
bool facesOutward(const assets::Mesh& exact, const RenderMesh& level);

}  // namespace tandem::client
