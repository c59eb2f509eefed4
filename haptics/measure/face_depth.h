#pragma once

// How deep the faces of one part are in another (the body). For penetration.cpp.

#include <vector>

#include "haptics/measure/ridge_depth.h"

namespace tandem::haptics {

class FaceDepth {
 public:
  FaceDepth(const DepthModel& faces, const DepthModel& body, const Pose& bodyFromFaces)
      : faces_(faces), body_(body), bodyFromFaces_(bodyFromFaces) {}

  /// Looks at the middle of the places where ridges of the body come through a facet, for what is deeper than
  /// `deepest`. Sorts `crossed`, whose points are in the faces' frame.
  void lookBetween(std::vector<CrossedFacet>& crossed, DeepestPoint& deepest) const;

  /// Searches all faces for what is deeper, within 1 % of the depth, unless 4000 pieces do not tell.
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
