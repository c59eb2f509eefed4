#pragma once

// Cylinders that a file states exactly, beside the facets that stand for them: which of them make fits, and
// facets laid so closely along these that contact feels the cylinder.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/base/constants.h"
#include "assets/mesh/mesh_analysis.h"

namespace tandem::assets {

/// A stretch of an exact cylinder, in the frame of its mesh.
struct RoundFace {
  glm::dvec3 point{0.0, 0.0, 0.0};  // m, on the axis
  glm::dvec3 axis{0.0, 0.0, 1.0};   // unit
  double radius = 0.0;              // m
  double from = 0.0, to = 0.0;      // m along the axis, from `point`
  bool hollow = false;              // a bore: the solid lies outside of it
  double turn = 2.0 * kPi;          // rad, how far it goes around
};

/// How the facets of a face are cut.
struct RoundCut {
  int segments = 0;    // of a whole turn; 0: its own facets will do
  double bound = 0.0;  // m, of a fit of equal radii: a cylinder about the same axis that no facet crosses
};

/// The cylinders that the file states for one mesh.
struct RoundFaces {
  std::vector<RoundFace> faces;
  std::vector<RoundCut> cuts;  // one a face; see planFits()
  std::size_t most = 0;        // triangles, and corners, that cutting may add; see planFits()
  bool movable = false;        // some part of this mesh is
  bool anyCut() const {
    return std::any_of(cuts.begin(), cuts.end(), [](const RoundCut& cut) { return cut.segments > 0; });
  }
};

/// Decides how finely each face is cut. A face counts as one of a fit if any other mesh, or its own, has a
/// face of nearly its radius and the other kind, and one of both can move. Its facets then may lie a tenth of
/// the radial play under the round, but no more than 320 go around. A shaft that is as wide as a bore gets
/// room to turn: see equalFitRoom(). Two million triangles are shared out among the meshes with fits; a mesh
/// that needs more keeps its facets. O(F log F).
void planFits(std::vector<RoundFaces>& meshes);

/// The play that a shaft and a bore of equal radii are given, m.
struct EqualFitRoom {
  double least = 0.0;  // between a corner of the shaft and the middle of a facet of the bore
  double most = 0.0;   // how far the shaft's axis may go aside
  double sag = 0.0;    // of the bore's facets
};

/// Without room the corners of a shaft that has turned by half a facet stand in the facets of its bore. The
/// axis may go aside by 4 um, less than contact promises (5 um), but by 6e-5 to 1e-3 of the radius.
EqualFitRoom equalFitRoom(double radius);

/// A mesh whose fits are cut anew.
struct RoundedMesh {
  TriangleSoup soup;             // empty where nothing was cut
  std::uint64_t felt = 0;        // faces whose facets now are as fine as planned
  std::uint64_t equal = 0;       // of these, faces that are given room to turn
  std::uint64_t unbelieved = 0;  // planned faces that do not lie on facets of the mesh
  double sag = 0.0;              // m, the largest that a felt face has left
  double room = 0.0;             // m, the most room that a fit of equal radii is given
};

/// Cuts the facets of the faces with segments along the axis, with new corners on the exact cylinder; flat
/// faces beside them follow the rim. A face is believed for a triangle only where the three corners lie on it
/// to within rounding and a facet spans less than a twelfth of a turn. Where a cut has a bound, the corners
/// of a shaft are put on it, and those of a bore so far outside that no facet lies within it. `rounding`: see
/// TriangleSoup.
RoundedMesh roundFaces(const Mesh& mesh, const RoundFaces& rounds, double rounding);

}  // namespace tandem::assets
