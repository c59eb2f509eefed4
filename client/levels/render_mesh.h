#pragma once

// Turns a Mesh into buffers for the GPU: vertices with crease-aware normals, triangles by material, feature
// edges. Pure functions; no GL.

#include <cstdint>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::client {

struct RenderVertex {
  glm::vec3 position{0.0f};  // m, part frame
  glm::vec3 normal{0.0f};    // unit
};

/// A run of triangles with one material.
struct RenderRange {
  std::uint16_t material = 0;
  std::uint32_t firstIndex = 0, indexCount = 0;
};

/// A run of neighbouring triangles within one range, and a sphere around them. Clusters out of view, or off a
/// picking ray, are skipped whole.
struct RenderCluster {
  std::uint32_t firstIndex = 0, indexCount = 0;
  glm::vec3 centre{0.0f};  // m, part frame
  float radius = 0.0f;     // m
};

struct RenderMesh {
  std::vector<RenderVertex> vertices;
  /// Three a triangle, ordered by material, then along a space-filling curve.
  std::vector<std::uint32_t> indices;
  std::vector<RenderRange> ranges;
  std::vector<RenderCluster> clusters;  // cover the indices without gap
  std::vector<glm::vec3> featureEdges;  // two points an edge, each edge once; sharp, open or non-manifold
};

/// The triangles of a mesh by material, then along a space-filling curve.
std::vector<std::uint32_t> drawingOrder(const assets::Mesh& mesh);

/// Fills the clusters, of some 1,000 triangles each, once indices and ranges are there.
void addClusters(RenderMesh& mesh);

/// Corners of a vertex share a normal where they can be reached over smooth edges; it is weighted by the
/// corners' angles (Thuermer and Wuethrich 1998). O(T). `points`, if not null, becomes the position in `mesh`
/// of each vertex.
RenderMesh makeRenderMesh(const assets::Mesh& mesh, std::vector<std::uint32_t>* points = nullptr);

/// Triangles for an implicit shape, for parts without a mesh. Infinite planes are drawn as `planeExtent` m
/// squares.
RenderMesh makeRenderMesh(const assets::ImplicitShape& shape, double planeExtent);

}  // namespace tandem::client
