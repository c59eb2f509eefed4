#pragma once

// Depth of the faces of one part in another (the body), used by penetration.cpp.

#include <vector>

#include "haptics/measure/ridge_depth.h"

namespace tandem::haptics {

class FaceDepth {
 public:
  FaceDepth(const DepthModel& faces, const DepthModel& body, const Pose& bodyFromFaces)
      : faces_(faces), body_(body), bodyFromFaces_(bodyFromFaces) {}

  /// Tests the middle of the places where ridges of the body cross a facet for a point deeper than `deepest`.
  /// Sorts `crossed`, whose points are in the faces' frame.
  void searchBetween(std::vector<CrossedFacet>& crossed, DeepestPoint& deepest) const;

  /// Searches all faces for a deeper point, within 1 % of the depth, or until 4000 pieces are used up.
  void search(DeepestPoint& deepest) const;

 private:
  struct Piece;

  /// Negative outside.
  DeepestPoint depthAt(const glm::dvec3& inBody, std::uint32_t& facet) const;
  void measure(Piece& piece, DeepestPoint& deepest) const;

  const DepthModel& faces_;
  const DepthModel& body_;
  Pose bodyFromFaces_;
};

}  // namespace tandem::haptics
