#pragma once

// Faces for the slits of a mesh: CAD exports leave seams of zero or little width where two surfaces were cut
// into triangles differently, or where faces without area were dropped. For construction of models, not for
// ticks.

#include <array>
#include <cstdint>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::haptics {

/// Triangles that close slits, counter-clockwise seen from outside as those of the mesh.
struct SlitCaps {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<double> width;  // m; no point of triangle i is further than this from the mesh
  bool complete = true;       // with them the mesh has no open edge
};

/// Closes every loop of open edges that ears can be cut from down to nothing without leaving its edges by
/// more than `widest`. Wider holes and loops of very many edges stay open.
SlitCaps capSlits(const assets::Mesh& mesh, double widest);

}  // namespace tandem::haptics
