#include "haptics/touch/patch_touch.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tandem::haptics {
namespace {

using Kind = ContactPatch::Kind;

/// The minimum of a convex function on [-half, half] by the root of its derivative `slope`, which does not
/// fall, or an end where there is no root. The least value is found to within `enough`.
template <typename Slope>
double whereLeast(double half, double enough, Slope&& slope) {
  double a = 0.0, fa = slope(0.0);
  if (std::abs(fa) * half <= enough) return 0.0;
  double b = fa > 0.0 ? -half : half, fb = slope(b);
  if (fa * fb > 0.0) return b;
  for (int k = 0; k < 24; ++k) {
    // Regula falsi; every third step bisects, for slopes that jump at an edge.
    const double c = k % 3 == 2 ? 0.5 * (a + b) : (a * fb - b * fa) / (fb - fa);
    const double fc = slope(c);
    if (std::abs(fc) * std::abs(b - a) <= enough) return c;
    if ((fc > 0.0) == (fa > 0.0)) {
      a = c, fa = fc;
    } else {
      b = c, fb = fc;
    }
    if (std::min(std::abs(fa), std::abs(fb)) * std::abs(b - a) <= enough) break;
  }
  return std::abs(fa) < std::abs(fb) ? a : b;
}

glm::dvec3 tangentOf(const ContactPatch& patch, const glm::dvec3& out) { return glm::cross(patch.axis, out); }

/// The piece of edge that a sample at `place` lies on, for the rules of crossing edges.
void setEdge(const ContactPatch& patch, const ContactPatch::Place& place, SampleQuery& sampleQuery) {
  if (patch.kind == Kind::straight) {
    sampleQuery.edge = patch.axis;
    sampleQuery.along = patch.along;
  } else if (patch.kind == Kind::rim) {
    sampleQuery.edge = tangentOf(patch, place.out);
    sampleQuery.along = patch.radius * patch.angle;
  }
}

/// Whether a round patch ends at a place, beyond which another patch or a rim is nearer.
bool endsAt(const ContactPatch& patch, const ContactPatch::Place& place) {
  if (patch.kind != Kind::cap && patch.kind != Kind::side) return false;
  return (patch.along > 0.0 && std::abs(place.t) > 0.999 * patch.along) ||
         glm::dot(place.out, patch.out) < std::cos(0.999 * patch.angle);
}

/// A place of a patch over a triangle, and its height above the triangle.
struct Candidate {
  ContactPatch::Place place;
  double height = 1e300;  // m
  std::uint32_t triangle = kNoTriangle;
};

/// Whether a patch can rest flat on a face with this normal there.
bool faces(const ContactPatch& patch, const ContactPatch::Place& place, const glm::dvec3& normal) {
  if (patch.kind == Kind::rim) {
    std::array<glm::dvec3, 2> own;
    patch.normalsAt(place, own);
    const glm::dvec3 across = normal - patch.axis * glm::dot(patch.axis, normal);
    const double length = glm::length(across);
    return glm::dot(normal, own[0]) < 0.05 && glm::dot(normal, own[1]) < 0.05 &&
           (length < 0.05 || glm::dot(across, place.out) < -0.99 * length);
  }
  std::array<glm::dvec3, 2> own;
  patch.normalsAt(place, own);
  return glm::dot(normal, own[0]) < -0.98;
}

Candidate over(const TriangleBvh& tree, const MeshEdges& edges, const ContactPatch& patch,
               std::uint32_t triangle, double slack, bool nearest) {
  Candidate found;
  found.triangle = triangle;
  const glm::dvec3 normal = edges.normal(triangle);
  if (!(glm::dot(normal, normal) > 0.5)) return found;
  found.place = patch.lowest(normal, slack);
  // A further face matters only if the patch can rest on it: the edge that it shares with the nearest face
  // is known.
  if (!nearest && !faces(patch, found.place, normal)) return found;
  const Triangle corners = tree.triangle(triangle);
  const glm::dvec3 p = patch.pointAt(found.place);
  if (closestPointOnTriangle(p, corners).onFace) {
    found.height = glm::dot(normal, p - corners.a);
    return found;
  }
  if (!nearest) return found;
  // The face ends before that place: the place of the patch that is nearest to the face counts.
  const glm::dvec3 q = closestPointOnTriangle(patch.centre + found.place.t * patch.axis, corners).point;
  found.place = patch.nearestTo(q);
  const glm::dvec3 nearer = patch.pointAt(found.place);
  const glm::dvec3 gap = nearer - closestPointOnTriangle(nearer, corners).point;
  std::array<glm::dvec3, 2> own;
  patch.normalsAt(found.place, own);
  found.height = std::copysign(glm::length(gap), -glm::dot(gap, own[0]));
  return found;
}

/// Descends from face to face to the one over which the patch is lowest.
Candidate lowestNear(const TriangleBvh& tree, const MeshEdges& edges, const ContactPatch& patch,
                     std::uint32_t triangle, double slack) {
  Candidate best = over(tree, edges, patch, triangle, slack, true);
  for (int k = 0; k < 8; ++k) {
    const std::uint32_t from = best.triangle;
    for (const std::uint32_t i : edges.around(from)) {
      for (const std::uint32_t beside : edges.line(i).triangles) {
        if (beside == from) continue;
        const Candidate other = over(tree, edges, patch, beside, slack, false);
        if (other.height < best.height - 1e-3 * slack) best = other;
      }
    }
    if (best.triangle == from) break;
  }
  return best;
}

/// The outward direction at a place of a patch, given that of its middle. Near an end it tilts past the
/// end, because what touches the end may lie on the surface beyond it.
glm::dvec3 outwardAt(const ContactPatch& patch, const ContactPatch::Place& place, const glm::dvec3& outward) {
  if (!(patch.along > 0.0) || outward == glm::dvec3(0.0)) return outward;
  return outward + (place.t / patch.along) * patch.axis;
}

glm::dvec3 unitOr(const glm::dvec3& v, const glm::dvec3& other) {
  const double length = glm::length(v);
  return length > 1e-9 ? v / length : other;
}

/// The edge as it is exposed where other shapes lie on its faces. False where other shapes cover all of it.
bool uncover(std::span<const Primitive> shapes, std::size_t which, const SampleQuery& sampleQuery,
             MeshEdge& edge) {
  if (shapes.size() == 1) return true;
  const glm::dvec3 along = edge.b - edge.a;
  const double square = glm::dot(along, along), size = 2.0 * sampleQuery.slack;
  const double t =
      square > 0.0 ? std::clamp(glm::dot(sampleQuery.point - edge.a, along) / square, 0.0, 1.0) : 0.0;
  const glm::dvec3 p = edge.a + t * along, n0 = edge.normals[0], n1 = edge.normals[1];
  const glm::dvec3 outward = unitOr(n0 + n1, n0);
  const double cosine = glm::dot(n0, n1);
  const bool first =
      coveredFace(shapes, which, p, -unitOr(n1 - cosine * n0, n1), outward, size, edge.normals[0]);
  const bool second =
      coveredFace(shapes, which, p, -unitOr(n0 - cosine * n1, n0), outward, size, edge.normals[1]);
  if (first && second) return false;
  if (!first && !second) return true;
  // Two faces in one plane make no edge, and in a hollow the planes of both faces are contacts.
  const glm::dvec3 crossed = glm::cross(edge.normals[0], edge.normals[1]);
  if (glm::dot(crossed, along) <= 1e-6 * std::sqrt(square))
    edge.normals[first ? 0 : 1] = edge.normals[first ? 1 : 0];
  edge.angle = std::acos(std::clamp(glm::dot(edge.normals[0], edge.normals[1]), -1.0, 1.0));
  return true;
}

}  // namespace

glm::dvec3 outwardOf(std::span<const glm::dvec3> normals) {
  glm::dvec3 sum(0.0);
  for (const glm::dvec3& normal : normals) sum += normal;
  return sum;
}

ContactPatch::Place deepestPlace(const Primitive& shape, const ContactPatch& patch, double slack) {
  ContactPatch::Place place{patch.out, 0.0};
  const double enough = 0.25 * slack, even = patch.along > 0.0 ? slack / (patch.along * patch.along) : 0.0;
  switch (patch.kind) {
    case Kind::cap:
      // The distance of a ball from a convex shape is its centre's less its radius.
      place = patch.lowest(shape.at(patch.centre).gradient, 0.0);
      break;
    case Kind::side: {
      const auto centre = [&](double t) { return patch.centre + t * patch.axis; };
      place.t = whereLeast(patch.along, enough, [&](double t) {
        return glm::dot(patch.axis, shape.at(centre(t)).gradient) - patch.grow + even * t;
      });
      place.out = patch.turned(-shape.at(centre(place.t)).gradient, slack);
      break;
    }
    case Kind::straight:
      place.t = whereLeast(patch.along, enough, [&](double t) {
        return glm::dot(patch.axis, shape.at(patch.centre + t * patch.axis).gradient) + even * t;
      });
      break;
    case Kind::rim: {
      const glm::dvec3 aside = tangentOf(patch, patch.out);
      const double evenAngle = slack / (patch.angle * patch.angle);
      const auto outAt = [&](double angle) { return std::cos(angle) * patch.out + std::sin(angle) * aside; };
      const double angle = whereLeast(patch.angle, enough, [&](double a) {
        const glm::dvec3 out = outAt(a);
        return patch.radius *
                   glm::dot(tangentOf(patch, out), shape.at(patch.centre + patch.radius * out).gradient) +
               evenAngle * a;
      });
      place.out = outAt(angle);
      break;
    }
  }
  return place;
}

PatchTouch deepestIn(const Primitive& shape, const ContactPatch& patch, double slack,
                     const glm::dvec3& outward) {
  PatchTouch touch;
  touch.place = deepestPlace(shape, patch, slack);
  touch.point = patch.pointAt(touch.place);
  touch.read = shape.against(touch.point, outwardAt(patch, touch.place, outward));
  return touch;
}

PatchTouch deepestIn(const DistanceField& field, const ContactPatch& patch, double slack, float& error) {
  PatchTouch best;
  best.place.out = patch.out;
  best.read.distance = 1e300;
  ContactPatch::Place place{patch.out, 0.0};
  for (int k = 0; k < 4; ++k) {
    const glm::dvec3 point = patch.pointAt(place);
    const DistanceField::Reading read = field.read(glm::vec3(point - field.origin()));
    const double distance = static_cast<double>(read.distance);
    const glm::dvec3 up(read.gradient);
    const double slope = glm::length(up);
    if (distance < best.read.distance) {
      best = {place, point, {distance, slope > 0.0 ? up / slope : up}};
      error = read.error;
    }
    if (!(slope > 0.1)) break;
    const ContactPatch::Place next = patch.lowest(up / slope, slack);
    // The depth there by this gradient must exceed the present one.
    if (glm::dot(up, patch.pointAt(next) - point) > -slack) break;
    place = next;
  }
  return best;
}

TouchingFeature touchingShape(std::span<const Primitive> shapes, std::size_t which, const ContactPatch* patch,
                              SampleQuery sampleQuery) {
  const Primitive& shape = shapes[which];
  std::array<glm::dvec3, 2> own;
  glm::dvec3 outward = outwardOf(sampleQuery.normals);
  if (patch != nullptr) {
    const ContactPatch::Place place = deepestPlace(shape, *patch, 0.1 * sampleQuery.slack);
    sampleQuery.point = patch->pointAt(place);
    setEdge(*patch, place, sampleQuery);
    if (const int count = patch->normalsAt(place, own); count > 0)
      sampleQuery.normals = {own.data(), static_cast<std::size_t>(count)};
    outward = outwardAt(*patch, place, outwardOf(sampleQuery.normals));
  }
  const SurfaceDistance read = shape.against(sampleQuery.point, outward);
  TouchingFeature found;
  found.count = 1;
  found.distance = std::abs(read.distance);
  found.triangle = shape.triangle();
  found.planes[0] = {sampleQuery.point, read.gradient, read.distance};
  const double path = std::max(glm::length(sampleQuery.motion), 10.0 * sampleQuery.slack);
  if (read.distance > 2.0 * (path + sampleQuery.along + sampleQuery.range)) return found;
  MeshEdge edge;
  if (!shape.edgeNear(sampleQuery.point, outward, std::max(path, 1.001 * found.distance), edge)) return found;
  if (!uncover(shapes, which, sampleQuery, edge)) {
    found.count = 0;
  } else if (edge.angle > 0.0) {
    found.planes[0] = touchingEdge(edge, sampleQuery);
  } else {
    found.planes[0] = {sampleQuery.point, edge.normals[0],
                       glm::dot(edge.normals[0], sampleQuery.point - edge.a)};
  }
  return found;
}

bool touchingPatch(const TriangleBvh& tree, const MeshEdges& edges, const ContactPatch& patch,
                   const ContactPatch::Place& start, SampleQuery sampleQuery, std::uint32_t hint,
                   TouchingFeature& found) {
  const double slack = 0.1 * sampleQuery.slack;
  ContactPatch::Place place = start;
  double height = 1e300;
  for (int k = 0; k < 4; ++k) {
    const glm::dvec3 p = patch.pointAt(place);
    MeshPoint nearest;
    if (!nearestPoint(tree, {}, p, 1e300, hint, nearest)) return false;
    if (nearest.triangle == hint && k > 0) break;
    const Candidate lower = lowestNear(tree, edges, patch, nearest.triangle, slack);
    hint = lower.triangle;
    if (!(lower.height < height - 0.1 * slack)) break;
    height = lower.height;
    place = lower.place;
  }
  // An edge of the mesh beyond the end of a patch is not parted from it by the patch's normals.
  if (endsAt(patch, place)) return false;
  for (int k = 0; k < 2; ++k) {
    sampleQuery.point = patch.pointAt(place);
    std::array<glm::dvec3, 2> own;
    if (const int count = patch.normalsAt(place, own); count > 0)
      sampleQuery.normals = {own.data(), static_cast<std::size_t>(count)};
    setEdge(patch, place, sampleQuery);
    if (!touchingFeature(tree, edges, sampleQuery, 1e300, hint, found)) return false;
    // Two edges cross beside that place, on the rim.
    if (patch.kind != Kind::rim || found.planes[0].point == sampleQuery.point) break;
    place = patch.nearestTo(found.planes[0].point);
  }
  return true;
}

}  // namespace tandem::haptics
