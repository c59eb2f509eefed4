#pragma once

// Facets of cylindrical faces that reach from circle to circle, laid at given angles. OpenCASCADE's mesher
// takes them over, and gives their neighbours the same edges.

#include <vector>

#include <TopoDS_Face.hxx>

#include "assets/cad_import/fit_rings.h"
#include "assets/cad_import/step_tree.h"

namespace tandem::cad_import {

/// A cylindrical face whose edges run along its axis or across it, and the ring of its body to which it
/// belongs.
struct RingFace {
  TopoDS_Face face;
  std::uint32_t ring = 0;     // into the list of rings
  double ringFromFace = 0.0;  // rad, added to an angle of the face's own
  bool mirrored = false;      // the face's angles run against the ring's
};

/// The ring faces of a body; appends its rings, coaxial faces of one radius together. `deflection` in mm.
/// `trimmed` counts cylindrical faces with other edges, which the mesher cuts as it likes.
std::vector<RingFace> findRingFaces(const Body& body, std::uint32_t index, double deflection,
                                    std::vector<Ring>& rings, std::size_t& trimmed);

/// Lays the facets of a face at its ring's angles and at its own corners.
void layRingFacets(const RingFace& ringFace, const std::vector<double>& angles);

}  // namespace tandem::cad_import
