#pragma once

// Pairs the edges of a triangle soup, for any number of faces at an edge and any orientation of them. A
// halfedge mesh cannot represent this part of the topology: edges of three and more faces, and faces that
// disagree on the outside.
//
// Halfedge h = 3 t + e is edge e of triangle t, from its corner e to its corner (e + 1) % 3.

#include <array>
#include <cstdint>
#include <vector>

namespace tandem::assets {

using TriangleIndices = std::array<std::uint32_t, 3>;

inline constexpr std::uint32_t kOpenEdge = 0xffffffffu;       // no other face
inline constexpr std::uint32_t kManyFacedEdge = 0xfffffffeu;  // more than two faces

/// The start and end vertex of halfedge h.
inline std::uint32_t startOf(const std::vector<TriangleIndices>& triangles, std::uint32_t h) {
  return triangles[h / 3][h % 3];
}
inline std::uint32_t endOf(const std::vector<TriangleIndices>& triangles, std::uint32_t h) {
  return triangles[h / 3][(h % 3 + 1) % 3];
}

/// The edges of T triangles.
struct EdgePairs {
  std::vector<std::uint32_t> across;  // 3T: the halfedge on the other side, or one of the marks above
  std::vector<std::vector<std::uint32_t>> manyFaced;  // halfedges of every edge with more than two faces
  std::uint64_t openEdges = 0;
};

/// Drops all but the first of the triangles that have the same three corners, in whatever order, together
/// with their entry of `material`. Returns how many were dropped. O(T log T).
std::uint64_t dropDuplicates(std::vector<TriangleIndices>& triangles, std::vector<std::uint16_t>& material,
                             std::size_t vertexCount);

/// Finds the edges of triangles that each have three different corners. O(T log T).
EdgePairs pairEdges(const std::vector<TriangleIndices>& triangles, std::size_t vertexCount);

/// How a soup was oriented.
struct Orientation {
  std::uint64_t flippedFaces = 0;
  std::uint64_t nonOrientableShells = 0;
};

/// Reverses triangles so that every two that share a two-faced edge agree on the outside. In each connected
/// shell the orientation of the majority of its faces remains. A shell that cannot be oriented (Möbius) keeps
/// edges whose two faces disagree.
Orientation orientAlike(std::vector<TriangleIndices>& triangles, EdgePairs& pairs);

/// The same triangle seen from its other side.
inline TriangleIndices reversed(const TriangleIndices& t) { return {t[0], t[2], t[1]}; }

/// The edge of reversed(t) that joins the same corners as edge e of t.
inline std::uint32_t reversedEdge(std::uint32_t e) { return 2 - e; }

}  // namespace tandem::assets
