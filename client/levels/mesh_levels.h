#pragma once

// Levels of detail of one mesh, each with the distance by which it is off. Pure functions; no GL.

#include <functional>
#include <vector>

#include "client/levels/render_mesh.h"

namespace tandem::client {

/// A mesh of this many triangles or more is drawn by levels where the scene is large.
inline constexpr std::size_t kLevelsFrom = 8'000;

/// What is drawn in place of a mesh.
struct Level {
  RenderMesh mesh;
  double error = 0.0;         // m: no point of either surface is further from the other one
  bool facesOutward = false;  // known to (facing.h): the backs of its faces need not be drawn
};

/// A rough level in some 10 ms per 200,000 triangles: the vertices of each cell of a grid become one, and
/// `error` is the most that one of them moves. A closed mesh stays closed.
Level standInFor(const assets::Mesh& mesh);

/// Levels of a mesh, the finest first, each with some 3.3 times fewer triangles than the one before, the last
/// with some hundreds. Empty where the mesh cannot be decimated, or if `stopped` holds; it is asked every few
/// ms.
std::vector<Level> makeLevels(const assets::Mesh& mesh, const std::function<bool()>& stopped);

}  // namespace tandem::client
