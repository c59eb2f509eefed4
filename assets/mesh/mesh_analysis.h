#pragma once

// Turns a soup of triangles, as files hold it, into a Mesh with topology, and reports its defects.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// Triangles as read from a file: V positions in m, T index triples (already range-checked), T materials.
struct TriangleSoup {
  std::vector<glm::dvec3> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint16_t> triangleMaterial;
  std::vector<std::array<glm::vec2, 3>> triangleUv;      // T texture coordinates of the corners, or empty
  std::vector<std::array<glm::vec3, 3>> triangleNormal;  // T normals of the corners, 0 = none, or empty
  /// m, by how much a coordinate may be off because the file rounds it; 0: half a unit in the last place of a
  /// float as large as the largest coordinate here.
  double rounding = 0.0;
};

/// Counts of what analyseMesh() found and changed.
struct MeshDefects {
  std::uint64_t duplicateVertices = 0;  // welded
  std::uint64_t degenerateFaces = 0;    // zero area after welding; dropped
  std::uint64_t duplicateFaces = 0;     // same three vertices, either orientation; all but one dropped
  std::uint64_t flippedFaces = 0;       // turned so that their shell is oriented alike
  std::uint64_t tJunctions = 0;         // vertices on an edge of another face; welded into it
  std::uint64_t invertedShells = 0;     // closed shells with negative volume; turned inside out
  std::uint64_t openShells = 0;         // shells with a boundary
  std::uint64_t boundaryEdges = 0;
  std::uint64_t nonManifoldEdges = 0;  // more than two faces
  std::uint64_t nonOrientableShells = 0;
  std::uint64_t sharpEdges = 0;      // not a defect
  std::uint64_t unusedVertices = 0;  // dropped
};

struct MeshAnalysis {
  Mesh mesh;
  MeshDefects defects;
};

/// Welds vertices to each other and to the edges that they lie on, drops degenerate and duplicate faces,
/// orients shells, finds neighbours, sharp edges, shells and volume. Positions must be finite. Triangles keep
/// the file's order, points stand in the order of first use. Scale-free: the welding distance is a share of
/// the mesh's coordinates (equal in the file's float precision), so a scene scaled by 1e-3 or 20 gives the
/// same topology. O(T log T), deterministic, one thread.
///
/// A shell is connected across edges of exactly two faces; edges of more (kEdgeNonManifold) have no
/// neighbours and separate shells. Which side of nested closed shells is solid: see shellsToInvert(). A
/// non-orientable shell keeps seams whose two faces are neighbours with opposite normals, flagged kEdgeSharp.
MeshAnalysis analyseMesh(TriangleSoup soup, double creaseAngle);

/// Volume, centre of mass and inertia of a closed mesh filled with `density` kg/m^3 (Mirtich 1996, "Fast and
/// accurate computation of polyhedral mass properties"), also of one whose edges of many faces are balanced,
/// such as two boxes that touch along an edge. Any other mesh counts as a uniform box of its bounds, at
/// least 1 % of the longest extent thick, that holds the volume its faces measure but at least a quarter of
/// the box. The inertia is positive definite for every mesh with a face; without one the mass is 0, unknown.
MassProperties massProperties(const Mesh& mesh, double density);

}  // namespace tandem::assets
