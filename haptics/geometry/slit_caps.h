#pragma once

// Caps for the slits of a mesh. CAD exports leave seams of little or no width where two surfaces were
// tessellated differently, or where faces without area were dropped. For construction of models, not for
// ticks.

#include <array>
#include <cstdint>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// Triangles that close slits, counter-clockwise seen from outside like those of the mesh.
struct SlitCaps {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<double> width;        // m; greatest distance of any point of triangle i from the mesh
  std::vector<std::uint32_t> loop;  // the loop of open edges that triangle i helps to close, ascending
  bool complete = true;             // with the caps the mesh has no open edge
};

/// Closes every loop of open edges that ear clipping can fill without deviating from its edges by more than
/// `widest`. Wider holes and very long loops stay open.
SlitCaps capSlits(const assets::Mesh& mesh, double widest);

/// Closes every loop of open edges: by ears, or by a fan about the first corner of a loop that is too long
/// for them. Always complete. The result depends on the order of vertices, not on the frame they are given
/// in: of ears that are equally high but for rounding, the first is clipped.
SlitCaps closeAllHoles(const assets::Mesh& mesh);

}  // namespace tandem::haptics
