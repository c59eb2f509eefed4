#include "haptics/touching_feature.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/segment.h"

namespace tandem::haptics {
namespace {

constexpr double kPi = 3.14159265358979323846;
// Two edges cross where they differ by more; along each other they touch in a whole line.
constexpr double kCrossing = 0.05;  // sine of the angle between them

/// Directions across an edge as angles from its first normal towards the second.
class EdgePlane {
 public:
  explicit EdgePlane(const MeshEdge& edge) : first_(edge.normals[0]) {
    const glm::dvec3 along = glm::normalize(edge.b - edge.a);
    second_ = glm::cross(along, first_);
    end_ = edge.angle;
  }
  /// Unrolled to within half a turn of the middle of the edge's own directions.
  double angle(const glm::dvec3& v) const {
    double a = std::atan2(glm::dot(v, second_), glm::dot(v, first_));
    if (a > 0.5 * end_ + kPi) a -= 2.0 * kPi;
    if (a < 0.5 * end_ - kPi) a += 2.0 * kPi;
    return a;
  }
  double length(const glm::dvec3& v) const { return std::hypot(glm::dot(v, second_), glm::dot(v, first_)); }
  glm::dvec3 direction(double a) const { return std::cos(a) * first_ + std::sin(a) * second_; }
  double end() const { return end_; }

 private:
  glm::dvec3 first_, second_;
  double end_;
};

/// The directions of an edge that are normal to the sample as well: low <= high.
struct Directions {
  double low, high;
};

Directions sharedDirections(const EdgePlane& plane, std::span<const glm::dvec3> normals) {
  double least = 1e300, most = -1e300;
  for (const glm::dvec3& normal : normals) {
    if (plane.length(normal) < 1e-6) continue;
    const double a = plane.angle(-normal);
    least = std::min(least, a);
    most = std::max(most, a);
  }
  Directions all{0.0, plane.end()};
  if (least > most || most - least >= kPi) return all;
  const double low = std::max(0.0, least), high = std::min(plane.end(), most);
  if (low <= high) return {low, high};
  // No direction is normal to both: the end of the edge's own that is nearest.
  return least > plane.end() ? Directions{plane.end(), plane.end()} : Directions{0.0, 0.0};
}

/// The shared direction in which the predicted offset from the edge is longest, with the present one not below
/// -slack where that can be: a corner that lies a hair over the rim must move by that hair, not climb around it.
glm::dvec3 partingDirection(const EdgePlane& plane, const Directions& shared, const glm::dvec3& offset,
                            const glm::dvec3& predicted, double slack) {
  double a = std::clamp(plane.angle(predicted), shared.low, shared.high);
  const double length = plane.length(offset);
  if (length > slack) {
    const double now = plane.angle(offset), limit = std::acos(-slack / length) - 1e-3;
    a = std::clamp(std::clamp(a, now - limit, now + limit), shared.low, shared.high);
  }
  return plane.direction(a);
}

/// Two edges that cross: normal to both, where each is an edge of its body that way.
bool crossingEdges(const MeshEdge& edge, const EdgePlane& plane, const SampleAtMesh& sample,
                   TouchingPlane& found) {
  const double length = glm::length(edge.b - edge.a);
  const glm::dvec3 along = (edge.b - edge.a) / length;
  glm::dvec3 normal = glm::cross(sample.edge, along);
  const double sine = glm::length(normal);
  if (sine < kCrossing) return false;
  normal /= sine;
  if (glm::dot(normal, plane.direction(0.5 * plane.end())) < 0.0) normal = -normal;
  const double a = plane.angle(normal), slack = 1e-3;
  if (a < -slack || a > plane.end() + slack) return false;
  // The sample's own normals enclose the opposite direction: it lies on the inner side of the plane of each.
  const glm::dvec3 &n0 = sample.normals[0], &n1 = sample.normals[1];
  const glm::dvec3 across0 = n1 - n0 * glm::dot(n0, n1), across1 = n0 - n1 * glm::dot(n0, n1);
  if (glm::dot(-normal, across0) < -slack || glm::dot(-normal, across1) < -slack) return false;
  // Closest points of the two lines (Ericson, Real-Time Collision Detection, 5.1.9).
  const glm::dvec3 r = sample.point - edge.a;
  const double b = glm::dot(sample.edge, along), c = glm::dot(sample.edge, r), f = glm::dot(along, r);
  const double s = (b * f - c) / (sine * sine), t = f + s * b;
  if (std::abs(s) > sample.along || t < 0.0 || t > length) return false;
  found.point = sample.point + s * sample.edge;
  found.normal = normal;
  found.gap = glm::dot(normal, found.point - (edge.a + t * along));
  return true;
}

/// The least gap to a convex edge of the list that crosses the sample's; false if none does within `reach`.
bool crossingNear(const MeshEdges& edges, std::uint32_t triangle, const SampleAtMesh& sample, double reach,
                  TouchingPlane& least) {
  bool any = false;
  for (const std::uint32_t i : edges.around(triangle)) {
    const MeshEdge& edge = edges.edges()[i];
    if (edge.angle < 0.0) continue;
    const glm::dvec3 offset = sample.point - closestPointOnSegment(sample.point, edge.a, edge.b);
    TouchingPlane found;
    if (glm::dot(offset, offset) > reach * reach || !crossingEdges(edge, EdgePlane(edge), sample, found))
      continue;
    if (any && found.gap >= least.gap) continue;
    any = true;
    least = found;
  }
  return any;
}

/// The convex edge of the list that is nearest to p, within `reach`.
const MeshEdge* nearestConvex(const MeshEdges& edges, std::uint32_t triangle, const glm::dvec3& p,
                              double reach, glm::dvec3& foot) {
  const MeshEdge* nearest = nullptr;
  double least = reach * reach;
  for (const std::uint32_t i : edges.around(triangle)) {
    const MeshEdge& edge = edges.edges()[i];
    if (edge.angle < 0.0) continue;
    const glm::dvec3 q = closestPointOnSegment(p, edge.a, edge.b);
    const double square = glm::dot(p - q, p - q);
    if (square > least) continue;
    least = square;
    nearest = &edge;
    foot = q;
  }
  return nearest;
}

/// The plane beyond a hollow edge beside the triangle that is predicted to be violated most, if there is one
/// within `reach`: a plane that ends further away than that means nothing here. Nor does one that the sample is less
/// far behind than it is from the mesh (`distance`): that one ends before it.
bool planeBeyond(const TriangleBvh& tree, const MeshEdges& edges, std::uint32_t triangle,
                 const SampleAtMesh& sample, double reach, double distance, TouchingPlane& found) {
  const glm::dvec3& p = sample.point;
  double least = 1e300;
  for (const std::uint32_t i : edges.around(triangle)) {
    const MeshEdge& edge = edges.edges()[i];
    if (edge.angle > 0.0) continue;
    const glm::dvec3 q = closestPointOnSegment(p, edge.a, edge.b);
    if (glm::dot(p - q, p - q) > 4.0 * reach * reach) continue;
    for (std::size_t side = 0; side < 2; ++side) {
      const glm::dvec3& normal = edge.normals[side];
      const double gap = glm::dot(normal, p - edge.a), predicted = gap + glm::dot(normal, sample.motion);
      if (predicted >= least || gap > reach || (gap < 0.0 && -gap < (1.0 - 1e-9) * distance)) continue;
      if (glm::dot(normal, edges.normal(triangle)) > 1.0 - 1e-9) continue;
      const Triangle beyond = tree.triangle(edge.triangles[side]);
      if (glm::length(p - closestPointOnTriangle(p, beyond).point) > reach) continue;
      least = predicted;
      found = {p, normal, gap};
    }
  }
  return least < 1e300;
}

/// Of an edge whose point nearest to the sample is `foot`.
TouchingPlane planeOfEdge(const MeshEdge& edge, const glm::dvec3& foot, const SampleAtMesh& sample,
                          double reach) {
  const EdgePlane plane(edge);
  const glm::dvec3 offset = sample.point - foot;
  const glm::dvec3 normal = partingDirection(plane, sharedDirections(plane, sample.normals), offset,
                                             offset + sample.motion, std::max(sample.slack, 1e-9 * reach));
  return {sample.point, normal, glm::dot(normal, offset)};
}

/// Of the convex edge near the sample, or of the triangle itself.
TouchingPlane nearestPlane(const TriangleBvh& tree, const MeshEdges& edges, std::uint32_t triangle,
                           const SampleAtMesh& sample, double reach) {
  const glm::dvec3& p = sample.point;
  TouchingPlane crossing;
  if (sample.along > 0.0 && crossingNear(edges, triangle, sample, reach + sample.along, crossing))
    return crossing;
  glm::dvec3 foot(0.0);
  const MeshEdge* const edge = nearestConvex(edges, triangle, p, reach, foot);
  if (edge == nullptr) {
    const glm::dvec3& normal = edges.normal(triangle);
    return {p, normal, glm::dot(normal, p - tree.triangle(triangle).a)};
  }
  return planeOfEdge(*edge, foot, sample, reach);
}

}  // namespace

TouchingPlane touchingEdge(const MeshEdge& edge, const SampleAtMesh& sample) {
  TouchingPlane found;
  if (sample.along > 0.0 && crossingEdges(edge, EdgePlane(edge), sample, found)) return found;
  return planeOfEdge(edge, closestPointOnSegment(sample.point, edge.a, edge.b), sample,
                     std::max(glm::length(sample.motion), 10.0 * sample.slack));
}

bool touchingFeature(const TriangleBvh& tree, const MeshEdges& edges, const SampleAtMesh& sample,
                     double reach, std::uint32_t hint, TouchingFeature& found) {
  const glm::dvec3& p = sample.point;
  double limit = reach;
  if (hint < tree.mesh().triangles.size()) {
    limit = std::min(limit, glm::length(p - closestPointOnTriangle(p, tree.triangle(hint)).point));
  }
  MeshPoint nearest;
  if (!tree.closestPoint(p, limit * (1.0 + 1e-12), nearest)) return false;
  found.triangle = nearest.triangle;
  found.distance = nearest.distance;
  const double way = std::max(glm::length(sample.motion), 10.0 * sample.slack);
  if (sample.outside && nearest.distance > sample.along + sample.range) {
    // Out of reach, it is held off by its distance alone: the planes of features mean nothing far from them.
    found.planes[0] = {p, (p - nearest.point) / nearest.distance, nearest.distance};
    found.count = 1;
    return true;
  }
  const double near = std::max(way, 1.001 * nearest.distance);
  found.planes[0] = nearestPlane(tree, edges, nearest.triangle, sample, near);
  found.count =
      planeBeyond(tree, edges, nearest.triangle, sample, near, found.distance, found.planes[1]) ? 2 : 1;
  return true;
}

}  // namespace tandem::haptics
