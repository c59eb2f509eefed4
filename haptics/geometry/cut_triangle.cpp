#include "haptics/geometry/cut_triangle.h"

#include <cmath>

#include "haptics/geometry/ball_passage.h"
#include "haptics/geometry/segment.h"

namespace tandem::haptics {
namespace {

constexpr double kThin = 1e-20;  // square of the flatness, or of the share of its size, that is rounding

/// m, 0 within rounding: a corner on the plane is cut into no two.
double inFront(const Section& section, const glm::dvec3& p) {
  const double along = glm::dot(section.normal, p), height = along - section.offset;
  return std::abs(height) > 0x1p-48 * (glm::length(p) + std::abs(section.offset)) ? height : 0.0;
}

bool reaches(const Section& section, const Triangle& t) {
  return inFront(section, t.a) > 0.0 || inFront(section, t.b) > 0.0 || inFront(section, t.c) > 0.0;
}

bool reaches(const Sections& sections, const Triangle& t) {
  for (const Section& section : sections)
    if (reaches(section, t)) return true;
  return false;
}

CutFace behind(const Section& section, const CutFace& face) {
  CutFace left;
  for (std::size_t i = 0; i < face.size(); ++i) {
    const glm::dvec3 &a = face[i], &b = face[i + 1 == face.size() ? 0 : i + 1];
    const double before = inFront(section, a), after = inFront(section, b);
    if (before <= 0.0) left.push_back(a);
    // From the end behind the plane, so that both triangles of an edge are cut in the same place.
    if (before < 0.0 && after > 0.0) left.push_back(a + (b - a) * (before / (before - after)));
    if (before > 0.0 && after < 0.0) left.push_back(b + (a - b) * (after / (after - before)));
  }
  return left;
}

TrianglePoint closestOnFace(const glm::dvec3& p, const Triangle& t, const CutFace& face) {
  const glm::dvec3 ab = t.b - t.a, ac = t.c - t.a, normal = glm::cross(ab, ac);
  const double square = glm::dot(normal, normal), size = glm::dot(ab, ab) + glm::dot(ac, ac);
  const bool flat = square > kThin * glm::dot(ab, ab) * glm::dot(ac, ac);
  const glm::dvec3 foot = flat ? p - normal * (glm::dot(normal, p - t.a) / square) : p;
  int sides = 0;
  bool inside = flat;
  TrianglePoint best{face[0], false};
  double least = glm::dot(p - face[0], p - face[0]);
  for (std::size_t i = 0; i < face.size(); ++i) {
    const glm::dvec3 &a = face[i], &b = face[i + 1 == face.size() ? 0 : i + 1];
    const glm::dvec3 along = b - a;
    if (!(glm::dot(along, along) > kThin * size)) continue;  // its direction is rounding
    ++sides;
    if (glm::dot(normal, glm::cross(along, foot - a)) > 0.0) continue;
    inside = false;
    const glm::dvec3 q = closestPointOnSegment(p, a, b);
    const double distance = glm::dot(p - q, p - q);
    if (distance >= least) continue;
    least = distance;
    best.point = q;
  }
  return inside && sides > 2 ? TrianglePoint{foot, true} : best;
}

}  // namespace

CutFace cutTriangle(const Triangle& triangle, const Sections& sections) {
  CutFace face;
  for (const glm::dvec3& corner : {triangle.a, triangle.b, triangle.c}) face.push_back(corner);
  for (const Section& section : sections)
    if (reaches(section, triangle)) face = behind(section, face);
  return face;
}

std::optional<TrianglePoint> closestPointOnCut(const glm::dvec3& p, const Triangle& triangle,
                                               const Sections& sections) {
  if (!reaches(sections, triangle)) return closestPointOnTriangle(p, triangle);
  const CutFace face = cutTriangle(triangle, sections);
  if (face.empty()) return std::nullopt;
  return closestOnFace(p, triangle, face);
}

bool sweepBallOnCut(const glm::dvec3& from, const glm::dvec3& motion, double radius, double tolerance,
                    const Triangle& triangle, const Sections& sections, BallHit& hit) {
  if (!reaches(sections, triangle)) return sweepBall(from, motion, radius, tolerance, triangle, hit);
  const CutFace face = cutTriangle(triangle, sections);
  if (face.empty()) return false;
  const auto closest = [&](const glm::dvec3& p) { return closestOnFace(p, triangle, face); };
  return sweepPast(
      BallPassage<decltype(closest)>{from, motion, radius, glm::length(motion), triangle, closest}, tolerance,
      hit);
}

}  // namespace tandem::haptics
