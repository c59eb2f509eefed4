#pragma once

// Cylinders that a file states exactly, beside the facets that stand for them: which of them make fits, and
// facets laid so closely along these that contact feels the cylinder.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/mesh/mesh_analysis.h"

namespace tandem::assets {

/// A stretch of an exact cylinder, in the frame of its mesh.
struct RoundFace {
  glm::dvec3 point{0.0, 0.0, 0.0};  // m, on the axis
  glm::dvec3 axis{0.0, 0.0, 1.0};   // unit
  double radius = 0.0;              // m
  double from = 0.0, to = 0.0;      // m along the axis, from `point`
  bool hollow = false;              // a bore: the solid lies outside of it
};

/// The cylinders that the file states for one mesh.
struct RoundFaces {
  std::vector<RoundFace> faces;
  std::vector<int> segments;  // one a face, of a whole turn; 0: its own facets will do. See planFits()
  std::size_t most = 0;       // triangles, and corners, that cutting may add; see planFits()
  bool movable = false;       // some part of this mesh is
};

/// Decides how finely each face is cut. A face counts as one of a fit if any other mesh, or its own, has a
/// face of nearly its radius and the other kind, and one of both can move. Its facets then may lie a tenth of
/// the radial play under the round, but no more than 320 go around. Where the nearest radius is the same
/// there is no play: facets that lie in each other corner in corner stay as they are. Two million triangles
/// are shared out among the meshes with fits; a mesh that needs more keeps its facets. O(F log F).
void planFits(std::vector<RoundFaces>& meshes);

/// A mesh whose fits are cut anew.
struct RoundedMesh {
  TriangleSoup soup;             // empty where nothing was cut
  std::uint64_t felt = 0;        // faces whose facets now are as fine as planned
  std::uint64_t unbelieved = 0;  // planned faces that do not lie on facets of the mesh
  double sag = 0.0;              // m, the largest that a felt face has left
};

/// Cuts the facets of the faces with segments along the axis, with new corners on the exact cylinder; flat
/// faces beside them follow the rim. A face is believed for a triangle only where the three corners lie on it
/// to within rounding and a facet spans less than a twelfth of a turn. `rounding`: see TriangleSoup.
RoundedMesh roundFaces(const Mesh& mesh, const RoundFaces& rounds, double rounding);

}  // namespace tandem::assets
