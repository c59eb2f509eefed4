#pragma once

// Open edges of a mesh that face each other across a slit: CAD programs tessellate the faces of a solid apart
// from each other, and their borders then differ by more than the file's rounding.

#include <cstdint>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// For edge e of triangle t, at 3 t + e: the triangle whose open edge runs back along it within `widest` m of
/// its middle, or kNone. Empty if the mesh has no open edges. O(B log B) for B open edges; for construction.
std::vector<std::uint32_t> facesBeyondBorders(const assets::Mesh& mesh, double widest);

}  // namespace tandem::haptics
