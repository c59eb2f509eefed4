#pragma once

// The shells of an oriented soup, found on an OpenMesh halfedge mesh.

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/mesh/edge_pairs.h"

namespace tandem::assets {

/// A connected set of faces. Faces are connected across edges that have exactly two of them.
struct Shell {
  bool hasBoundary = false;
  /// Whether its faces pass every edge equally often in both directions, so that the shell bounds a volume.
  /// Two boxes that touch along an edge are closed too, although that edge has four faces.
  bool closed = true;
  double signedVolume = 0.0;  // m^3; negative if inside out; meaningful if closed
  std::uint32_t firstFace = 0;
};

/// Topology of T triangles; see Mesh for the shapes.
struct HalfedgeTopology {
  std::vector<std::array<std::uint32_t, 3>> neighbours;
  std::vector<std::array<std::uint8_t, 3>> edgeFlags;
  std::vector<std::uint32_t> triangleShell;
  std::vector<Shell> shells;
  std::uint64_t sharpEdges = 0;
};

/// Builds the halfedge mesh and reads neighbours, boundaries, sharp edges (rad), shells and volumes from it.
/// `reference` is a point near the mesh, about which volumes are summed, to keep their digits.
HalfedgeTopology findTopology(const std::vector<glm::dvec3>& points,
                              const std::vector<TriangleIndices>& triangles, const EdgePairs& pairs,
                              double creaseAngle, const glm::dvec3& reference);

}  // namespace tandem::assets
