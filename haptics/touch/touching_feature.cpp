#include "haptics/touch/touching_feature.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/geometry/segment.h"
#include "haptics/touch/edge_directions.h"

namespace tandem::haptics {
namespace {

// Sine of the angle above which two edges cross; below it they touch along a line.
constexpr double kCrossing = 0.05;

/// Whether the edge passes through the region behind all faces of the sample, within `reach` (m) of the
/// sample.
bool cutsSample(const MeshEdge& edge, const SampleQuery& sample, double reach) {
  const double length = glm::length(edge.b - edge.a);
  const glm::dvec3 along = (edge.b - edge.a) / length, from = edge.a - sample.point;
  const double foot = -glm::dot(from, along);
  double low = std::max(0.0, foot - reach), high = std::min(length, foot + reach);
  for (const glm::dvec3& normal : sample.normals) {
    const double at = glm::dot(normal, from), rate = glm::dot(normal, along);
    if (std::abs(rate) < 1e-9) {
      if (at > 0.0) return false;
    } else if (rate > 0.0) {
      high = std::min(high, -at / rate);
    } else {
      low = std::max(low, -at / rate);
    }
  }
  return low < high;
}

/// Where the lines of a sample's edge and of another are nearest to each other.
struct Crossing {
  glm::dvec3 along, across;  // unit: along the other edge; normal to both
  double onSample, onEdge;   // m, from the sample's point, and from the first end of the other edge
};

/// Whether two edges cross now or at the end of the sample's motion, up to `past` m beyond the ends of
/// `edge`.
bool linesCross(const EdgeLine& edge, const SampleQuery& sample, double past, Crossing& at) {
  const double length = glm::length(edge.b - edge.a);
  at.along = (edge.b - edge.a) / length;
  at.across = glm::cross(sample.edge, at.along);
  const double sine = glm::length(at.across);
  if (sine < kCrossing) return false;
  at.across /= sine;
  // Closest points of the two lines (Ericson, Real-Time Collision Detection, 5.1.9).
  const double b = glm::dot(sample.edge, at.along);
  const auto cross = [&](const glm::dvec3& r) {
    const double c = glm::dot(sample.edge, r), f = glm::dot(at.along, r);
    at.onSample = (b * f - c) / (sine * sine);
    at.onEdge = f + at.onSample * b;
    return std::abs(at.onSample) <= sample.along && at.onEdge >= -past && at.onEdge <= length + past;
  };
  const glm::dvec3 r = sample.point - edge.a;
  // The corner at the end of one edge may slide off the other, and the edges then cross beside it.
  const bool atTheEnd = cross(r + sample.motion);
  return cross(r) || atTheEnd;
}

/// The plane of two edges that cross, normal to both, where each is an edge of its body in that direction.
bool crossingEdges(const MeshEdge& edge, const SampleQuery& sample, const Crossing& at,
                   TouchingPlane& found) {
  const EdgePlane plane(edge);
  glm::dvec3 normal = at.across;
  if (glm::dot(normal, plane.direction(0.5 * plane.end())) < 0.0) normal = -normal;
  const double a = plane.angle(normal), slack = 1e-3;
  if (a < -slack || a > plane.end() + slack) return false;
  // The normals of the sample must enclose the opposite direction, which then is on the inner side of each.
  const glm::dvec3 &n0 = sample.normals[0], &n1 = sample.normals[1];
  const glm::dvec3 across0 = n1 - n0 * glm::dot(n0, n1), across1 = n0 - n1 * glm::dot(n0, n1);
  if (glm::dot(-normal, across0) < -slack || glm::dot(-normal, across1) < -slack) return false;
  found.point = sample.point + at.onSample * sample.edge;
  found.normal = normal;
  found.gap = glm::dot(normal, found.point - (edge.a + at.onEdge * at.along));
  return true;
}

/// The least gap to a convex edge of the list that crosses the sample's, or does so up to `past` m beyond its
/// ends; false if none does within `reach`.
bool crossingNear(const MeshEdges& edges, std::uint32_t triangle, const SampleQuery& sample, double reach,
                  double past, TouchingPlane& least) {
  bool any = false;
  for (const std::uint32_t i : edges.around(triangle)) {
    if (!edges.isConvex(i)) continue;
    const EdgeLine line = edges.line(i);
    const glm::dvec3 offset = sample.point - closestPointOnSegment(sample.point, line.a, line.b);
    Crossing at;
    TouchingPlane found;
    if (glm::dot(offset, offset) > reach * reach || !linesCross(line, sample, past, at) ||
        !crossingEdges(edges.edge(i), sample, at, found))
      continue;
    if (any && found.gap >= least.gap) continue;
    any = true;
    least = found;
  }
  return any;
}

/// The convex edge of the list that is nearest to p, within `reach`; kNone if there is none.
std::uint32_t nearestConvex(const MeshEdges& edges, std::uint32_t triangle, const glm::dvec3& p, double reach,
                            glm::dvec3& foot) {
  std::uint32_t nearest = assets::kNone;
  double least = reach * reach;
  for (const std::uint32_t i : edges.around(triangle)) {
    if (!edges.isConvex(i)) continue;
    const EdgeLine edge = edges.line(i);
    const glm::dvec3 q = closestPointOnSegment(p, edge.a, edge.b);
    const double square = glm::dot(p - q, p - q);
    if (square > least) continue;
    least = square;
    nearest = i;
    foot = q;
  }
  return nearest;
}

/// Adds the plane beyond a hollow edge of the triangle that is predicted to be violated most, if one is
/// within `reach`: a plane that ends further away constrains nothing here. A sample in front of the mesh also
/// ignores a plane that it is less far behind than it is from the mesh, for that plane ends before the
/// sample. Where the face beyond ends under a piece of edge, the plane is that of both edges: the two planes
/// of a hollow corner at the mouth of a bore then lean as one, and nothing pushes along the bore by turns.
void addPlaneBeyond(const TriangleBvh& tree, const MeshEdges& edges, const SampleQuery& sample, double reach,
                    TouchingFeature& feature) {
  const glm::dvec3& p = sample.point;
  const glm::dvec3 known = edges.normal(feature.triangle);
  const bool behind = feature.planes[0].gap < 0.0;
  double least = 1e300;
  for (const std::uint32_t i : edges.around(feature.triangle)) {
    if (edges.isConvex(i)) continue;
    const EdgeLine edge = edges.line(i);
    const glm::dvec3 q = closestPointOnSegment(p, edge.a, edge.b);
    if (glm::dot(p - q, p - q) > 4.0 * reach * reach) continue;
    const auto normals = edges.normals(i);
    for (std::size_t side = 0; side < 2; ++side) {
      const glm::dvec3& normal = normals[side];
      const double gap = glm::dot(normal, p - edge.a), predicted = gap + glm::dot(normal, sample.motion);
      if (predicted >= least || gap > reach || glm::dot(normal, known) > 1.0 - 1e-9) continue;
      if (!behind && gap < 0.0 && -gap < (1.0 - 1e-9) * feature.distance) continue;
      const Triangle beyond = tree.triangle(edge.triangles[side]);
      if (glm::length(p - closestPointOnTriangle(p, beyond).point) > reach) continue;
      least = predicted;
      TouchingPlane& plane = feature.planes[1];
      const bool crosses =
          sample.along > 0.0 && crossingNear(edges, edge.triangles[side], sample, reach, reach, plane);
      if (!crosses) plane = {p, normal, gap};
      feature.count = 2;
    }
  }
}

/// m by which a gap may be below zero.
double slackOf(const SampleQuery& sample, double reach) { return std::max(sample.slack, 1e-9 * reach); }

/// m^2, the square of the distance up to which two points are the same.
double same(double reach) { return 1e-18 * reach * reach + 1e-24; }

/// Whether the edge passes through the point.
bool passes(const EdgeLine& edge, const glm::dvec3& point, double reach) {
  const glm::dvec3 offset = point - closestPointOnSegment(point, edge.a, edge.b);
  return glm::dot(offset, offset) <= same(reach);
}

/// Whether the point is the end of a convex edge where no hollow one passes.
bool isConvexCorner(const MeshEdges& edges, std::uint32_t triangle, const MeshEdge& edge,
                    const glm::dvec3& point, double reach) {
  const glm::dvec3 a = point - edge.a, b = point - edge.b;
  if (std::min(glm::dot(a, a), glm::dot(b, b)) > same(reach)) return false;
  return std::none_of(edges.around(triangle).begin(), edges.around(triangle).end(), [&](std::uint32_t i) {
    return !edges.isConvex(i) && passes(edges.line(i), point, reach);
  });
}

/// The plane of an edge whose point nearest to the sample is `foot`, along the separating direction of the
/// largest predicted gap.
TouchingPlane partingPlane(const EdgePlane& plane, const Directions& shared, const glm::dvec3& foot,
                           const SampleQuery& sample, double reach) {
  const glm::dvec3 offset = sample.point - foot;
  const glm::dvec3 normal =
      partingDirection(plane, shared, offset, offset + sample.motion, slackOf(sample, reach));
  return {sample.point, normal, glm::dot(normal, offset)};
}

/// The same along a direction that is normal to both. False if there is none, or if none separates them
/// although they do not meet: the two bodies are then nearest to each other elsewhere.
bool commonPlane(const MeshEdge& edge, const EdgePlane& plane, const glm::dvec3& foot,
                 const SampleQuery& sample, double reach, TouchingPlane& found) {
  const Directions shared = commonDirections(plane, sample.normals);
  if (shared.none()) return false;
  found = partingPlane(plane, shared, foot, sample, reach);
  return found.gap >= -slackOf(sample, reach) || cutsSample(edge, sample, 4.0 * reach);
}

/// m, the gap at the end of the sample's motion.
double predicted(const TouchingPlane& plane, const SampleQuery& sample) {
  return plane.gap + glm::dot(plane.normal, sample.motion);
}

/// The plane of an edge for any sample. Two edges that run along each other also touch beyond the sample,
/// where a direction that is nearly normal to both separates them. Where an interference fit takes a corner
/// of a seat's rim back, any direction that separates the corner from the plug will do, because the rim is
/// hollow there.
TouchingPlane planeOfEdge(const MeshEdge& edge, const glm::dvec3& foot, const SampleQuery& sample,
                          double reach) {
  const EdgePlane plane(edge);
  TouchingPlane found;
  const bool common = sample.normals.size() > 2 && commonPlane(edge, plane, foot, sample, reach, found);
  if (common && !sample.shifted) return found;
  const TouchingPlane near =
      partingPlane(plane, nearestDirections(plane, sample.normals), foot, sample, reach);
  return common && predicted(found, sample) >= predicted(near, sample) ? found : near;
}

/// The plane of the largest predicted gap among those of all convex edges that meet in the corner `foot`;
/// false if none is normal to both.
bool planeOfCorner(const MeshEdges& edges, std::uint32_t triangle, const glm::dvec3& foot,
                   const SampleQuery& sample, double reach, TouchingPlane& found) {
  double furthest = -1e300;
  for (const std::uint32_t i : edges.around(triangle)) {
    if (!edges.isConvex(i) || !passes(edges.line(i), foot, reach)) continue;
    const MeshEdge edge = edges.edge(i);
    TouchingPlane plane;
    if (!commonPlane(edge, EdgePlane(edge), foot, sample, reach, plane)) continue;
    const double gap = predicted(plane, sample);
    if (gap <= furthest) continue;
    furthest = gap;
    found = plane;
  }
  return furthest > -1e300;
}

/// The plane of the convex edge near the sample, or of the triangle itself. Where edges meet in a corner
/// that is as near, any separating plane is enough, unless the corner is hollow too.
TouchingPlane nearestPlane(const TriangleBvh& tree, const MeshEdges& edges, std::uint32_t triangle,
                           const SampleQuery& sample, double reach) {
  const glm::dvec3& p = sample.point;
  TouchingPlane crossing;
  if (sample.along > 0.0 && crossingNear(edges, triangle, sample, reach + sample.along, 0.0, crossing))
    return crossing;
  glm::dvec3 foot(0.0);
  const std::uint32_t nearest = nearestConvex(edges, triangle, p, reach, foot);
  if (nearest == assets::kNone) {
    const glm::dvec3 normal = edges.normal(triangle);
    return {p, normal, glm::dot(normal, p - tree.triangle(triangle).a)};
  }
  const MeshEdge edge = edges.edge(nearest);
  TouchingPlane found;
  if (!isConvexCorner(edges, triangle, edge, foot, reach) ||
      !planeOfCorner(edges, triangle, foot, sample, reach, found))
    return planeOfEdge(edge, foot, sample, reach);
  if (!sample.shifted) return found;
  const TouchingPlane single = planeOfEdge(edge, foot, sample, reach);
  return predicted(found, sample) >= predicted(single, sample) ? found : single;
}

}  // namespace

bool nearestPoint(const TriangleBvh& tree, std::span<const std::uint32_t> near, const glm::dvec3& p,
                  double reach, std::uint32_t hint, MeshPoint& nearest) {
  constexpr double kRounding = 1.0 + 1e-12;
  if (!near.empty()) return tree.closestPointAmong(near, p, reach * kRounding, nearest);
  double limit = reach;
  if (hint < tree.mesh().triangles.size())
    limit = std::min(limit, glm::length(p - closestPointOnTriangle(p, tree.triangle(hint)).point));
  return tree.closestPoint(p, limit * kRounding, nearest);
}

TouchingPlane touchingEdge(const MeshEdge& edge, const SampleQuery& sample) {
  TouchingPlane found;
  Crossing at;
  if (sample.along > 0.0 && linesCross(edge, sample, 0.0, at) && crossingEdges(edge, sample, at, found))
    return found;
  return planeOfEdge(edge, closestPointOnSegment(sample.point, edge.a, edge.b), sample,
                     std::max(glm::length(sample.motion), 10.0 * sample.slack));
}

bool touchingFeature(const TriangleBvh& tree, const MeshEdges& edges, const SampleQuery& sample, double reach,
                     std::uint32_t hint, TouchingFeature& found) {
  const glm::dvec3& p = sample.point;
  MeshPoint nearest;
  if (!nearestPoint(tree, sample.near, p, reach, hint, nearest)) return false;
  found.triangle = nearest.triangle;
  found.distance = nearest.distance;
  const double path = std::max(glm::length(sample.motion), 10.0 * sample.slack);
  if (sample.outside && nearest.distance > sample.along + sample.range) {
    // Out of reach the distance alone makes the plane, because the planes of a feature are valid only near
    // it.
    found.planes[0] = {p, (p - nearest.point) / nearest.distance, nearest.distance};
    found.count = 1;
    return true;
  }
  const double near = std::max(path, 1.001 * nearest.distance);
  found.planes[0] = nearestPlane(tree, edges, nearest.triangle, sample, near);
  found.count = 1;
  addPlaneBeyond(tree, edges, sample, near, found);
  return true;
}

}  // namespace tandem::haptics
