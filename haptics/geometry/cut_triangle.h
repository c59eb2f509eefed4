#pragma once

// What sections leave of a triangle: a convex polygon in its plane. All its edges are solid, those of the cut
// too; the cut surface of the solid is none.

#include <optional>

#include "haptics/base/section.h"
#include "haptics/geometry/triangle_math.h"

namespace tandem::haptics {

/// The corners in the order of the triangle's; empty if nothing is left. Some may coincide.
using CutFace = FixedVector<glm::dvec3, 3 + kMaxSections>;

inline bool isCutAway(const Sections& sections, const glm::dvec3& p) {
  for (const Section& section : sections)
    if (glm::dot(section.normal, p) > section.offset) return true;
  return false;
}

/// What is left of a triangle (Sutherland & Hodgman 1974, "Reentrant polygon clipping").
CutFace cutTriangle(const Triangle& triangle, const Sections& sections);

/// The nearest point of what is left of a triangle; none if nothing is.
std::optional<TrianglePoint> closestPointOnCut(const glm::dvec3& p, const Triangle& triangle,
                                               const Sections& sections);

/// sweepBall() of triangle_math.h against what is left of a triangle.
bool sweepBallOnCut(const glm::dvec3& from, const glm::dvec3& motion, double radius, double tolerance,
                    const Triangle& triangle, const Sections& sections, BallHit& hit);

}  // namespace tandem::haptics
