#pragma once

// Exact relations between a point or a moving ball and one triangle, in double precision.

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace tandem::haptics {

/// Three corners, counter-clockwise from outside.
struct Triangle {
  glm::dvec3 a, b, c;
};

/// Outward normal with the length of twice the triangle's area, m^2.
inline glm::dvec3 areaVector(const Triangle& t) { return glm::cross(t.b - t.a, t.c - t.a); }

/// The point of a triangle closest to another point.
struct TrianglePoint {
  glm::dvec3 point{0.0, 0.0, 0.0};
  bool onFace = false;  // inside the triangle, neither on an edge nor a corner
};

/// Closest point by the Voronoi regions of Ericson, "Real-Time Collision Detection", 5.1.5. Triangles without
/// area are handled as edges.
TrianglePoint closestPointOnTriangle(const glm::dvec3& p, const Triangle& triangle);

/// The first instant at which the distance of a moving ball's centre to a triangle equals its radius.
struct BallHit {
  double t = 1.0;                    // share of the motion, 0..1
  glm::dvec3 point{0.0, 0.0, 0.0};   // on the triangle
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit, from the triangle to the ball's centre
  bool onFace = false;
};

/// Unit normal of the triangle at `closest`, on the side of p: the face normal on the face, the direction
/// from the closest point elsewhere.
glm::dvec3 contactNormal(const glm::dvec3& p, const Triangle& triangle, const TrianglePoint& closest);

/// Continuous collision detection of a ball: the first t in [0, hit.t] at which the distance of from + t *
/// motion to the triangle falls to `radius`, found within `tolerance` above it and never below. False if
/// there is none or the ball does not approach. Both sides are solid. The distance to a convex set is a
/// convex function of t, so Newton's iteration from t = 0 approaches its first root from below and never
/// passes it.
bool sweepBall(const glm::dvec3& from, const glm::dvec3& motion, double radius, double tolerance,
               const Triangle& triangle, BallHit& hit);

}  // namespace tandem::haptics
