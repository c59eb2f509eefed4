#include "haptics/geometry/primitive_distance.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "assets/base/assert.h"
#include "assets/base/constants.h"

namespace tandem::haptics {
namespace {

using Kind = assets::ImplicitShape::Kind;

const glm::dvec3 kUp(0.0, 1.0, 0.0);
// Half length of the tangent that represents a rim, as a fraction of the rim's radius.
constexpr double kTangent = 0.1;
// Below this length a vector has no direction, because denormal numbers have too few digits.
constexpr double kTiny = 1e-290;

// Cosine to a face's normal above which another surface does not face it.
constexpr double kAgainst = -1e-3;
// Fraction of a shape's extent within which a point counts as on the surface, because of rounding, and is
// treated as inside.
constexpr double kRounding = 1e-13;

/// Whether a surface with the outward direction `outward` can rest on a face with this unit normal.
bool restsOn(const glm::dvec3& outward, const glm::dvec3& normal) {
  return glm::dot(outward, normal) <= kAgainst * glm::length(outward);
}

/// The three faces of a box on these sides, each with whether such a surface can rest on it.
std::array<bool, 3> facesToRestOn(const glm::dvec3& outward, const glm::dvec3& sign) {
  const glm::dvec3 facing = sign * outward;
  const double limit = kAgainst * glm::length(outward);
  return {facing.x <= limit, facing.y <= limit, facing.z <= limit};
}

double signOf(double x) { return x < 0.0 ? -1.0 : 1.0; }

/// Unit vector across the Y axis towards p; an arbitrary one where p is on the axis.
glm::dvec3 radial(const glm::dvec3& p, double radius) {
  return radius > kTiny ? glm::dvec3(p.x / radius, 0.0, p.z / radius) : glm::dvec3(1.0, 0.0, 0.0);
}

/// An edge through `foot` that extends by `half` to both sides.
MeshEdge edgeOf(const glm::dvec3& foot, const glm::dvec3& along, double half, const glm::dvec3& first,
                const glm::dvec3& second, double angle) {
  MeshEdge edge;
  edge.a = foot - half * along;
  edge.b = foot + half * along;
  edge.normals = {first, second};
  edge.angle = angle;
  return edge;
}

}  // namespace

Primitive::Primitive(const assets::ImplicitShape& shape, std::uint32_t triangle)
    : kind_(shape.kind),
      shapeFromPart_(glm::mat3_cast(glm::conjugate(shape.partFromShape.orientation))),
      centre_(shape.partFromShape.position),
      triangle_(triangle) {
  double reach = 0.0;
  switch (kind_) {
    case Kind::box:
      half_ = 0.5 * glm::abs(shape.size);
      reach = glm::length(half_);
      break;
    case Kind::plane:
      half_ = 0.5 * glm::dvec3(std::abs(shape.size.x), 0.0, std::abs(shape.size.z));
      reach = glm::length(half_);
      break;
    case Kind::sphere:
      top_ = bottom_ = reach = std::abs(shape.radiusBottom);
      break;
    case Kind::capsule:
    case Kind::cylinder:
      top_ = std::abs(shape.radiusTop);
      bottom_ = std::abs(shape.radiusBottom);
      halfHeight_ = 0.5 * std::abs(shape.height);
      reach = halfHeight_ + std::max(top_, bottom_);
      break;
  }
  const double height = 2.0 * halfHeight_, more = top_ - bottom_;
  if (kind_ == Kind::capsule) {
    if (height <= std::abs(more)) {
      // One sphere contains the other.
      centre_ += shape.partFromShape.orientation * (signOf(more) * halfHeight_ * kUp);
      top_ = bottom_ = std::max(top_, bottom_);
      halfHeight_ = 0.0;
    } else {
      grow_ = more / height;
    }
  } else if (kind_ == Kind::cylinder) {
    if (!(height > 0.0)) top_ = bottom_ = std::max(top_, bottom_);  // a disc
    const double slant = std::hypot(height, top_ - bottom_);
    grow_ = slant > 0.0 ? (top_ - bottom_) / slant : 0.0;
    across_ = slant > 0.0 ? height / slant : 1.0;
  }
  if (kind_ != Kind::cylinder) across_ = std::sqrt(std::max(0.0, (1.0 - grow_) * (1.0 + grow_)));
  extent_ = std::max({std::abs(centre_.x), std::abs(centre_.y), std::abs(centre_.z)}) + reach;
  rounding_ = std::max(kTiny, kRounding * extent_);
}

SurfaceDistance Primitive::against(const glm::dvec3& inPart, const glm::dvec3& outwardInPart) const {
  const glm::dvec3 p = shapeFromPart_ * (inPart - centre_), outward = shapeFromPart_ * outwardInPart;
  SurfaceDistance found;
  switch (kind_) {
    case Kind::box:
      found = ofBox(p, outward);
      break;
    case Kind::plane:
      found = ofPlane(p);
      break;
    case Kind::sphere:
    case Kind::capsule:
      found = ofCapsule(p);
      break;
    case Kind::cylinder:
      found = ofCylinder(p, outward);
      break;
  }
  found.gradient = found.gradient * shapeFromPart_;
  return found;
}

SurfaceDistance Primitive::ofBox(const glm::dvec3& p, const glm::dvec3& outward) const {
  const glm::dvec3 beyond = glm::abs(p) - half_;
  const glm::dvec3 out = glm::max(beyond, glm::dvec3(0.0));
  const double square = glm::dot(out, out);
  const glm::dvec3 sign(signOf(p.x), signOf(p.y), signOf(p.z));
  if (square > rounding_ * rounding_) {
    const double length = std::sqrt(square);
    return {length, sign * out / length};
  }
  const std::array<bool, 3> supports = facesToRestOn(outward, sign);
  const bool any = supports[0] || supports[1] || supports[2];
  int axis = -1;
  for (int k = 0; k < 3; ++k)
    if ((supports[static_cast<std::size_t>(k)] || !any) && (axis < 0 || beyond[k] > beyond[axis])) axis = k;
  glm::dvec3 gradient(0.0);
  gradient[axis] = sign[axis];
  return {beyond[axis], gradient};
}

SurfaceDistance Primitive::ofPlane(const glm::dvec3& p) const {
  const glm::dvec3 out(std::max(0.0, std::abs(p.x) - half_.x) * signOf(p.x), p.y,
                       std::max(0.0, std::abs(p.z) - half_.z) * signOf(p.z));
  const double square = glm::dot(out, out);
  if (out.x == 0.0 && out.z == 0.0) return {std::abs(p.y), signOf(p.y) * kUp};
  if (!(square > kTiny)) return {0.0, kUp};
  const double length = std::sqrt(square);
  return {length, out / length};
}

/// A capsule is the union of the spheres along its axis. The distance is the least over these spheres, inside
/// too, because the axis is the set of points furthest from the surface. The direction of the deciding sphere
/// is tilted by `grow`.
SurfaceDistance Primitive::ofCapsule(const glm::dvec3& p) const {
  const double radius = std::hypot(p.x, p.z);
  const double y =
      across_ > 0.0 ? std::clamp(p.y + radius * grow_ / across_, -halfHeight_, halfHeight_) : 0.0;
  const double of = bottom_ + (y + halfHeight_) * grow_, up = p.y - y;
  const double length = std::hypot(radius, up);
  if (!(length > kTiny)) return {-of, glm::dvec3(across_, -grow_, 0.0)};
  const glm::dvec3 out = radial(p, radius);
  return {length - of, (radius / length) * out + (up / length) * kUp};
}

/// Works in the half-plane of the axis and the point, where the cylinder is a trapezoid with the axis as one
/// side.
SurfaceDistance Primitive::ofCylinder(const glm::dvec3& p, const glm::dvec3& outward) const {
  const double radius = std::hypot(p.x, p.z);
  const glm::dvec3 out = radial(p, radius);
  const bool upper = p.y >= 0.0;
  const double cap = std::abs(p.y) - halfHeight_, capSign = upper ? 1.0 : -1.0;
  // Along the side from the bottom rim to the top rim, and out of it.
  const double fromBottom = radius - bottom_, height = p.y + halfHeight_;
  const double slant = std::hypot(2.0 * halfHeight_, top_ - bottom_);
  const double side = across_ * fromBottom - grow_ * height, along = grow_ * fromBottom + across_ * height;
  if (cap <= rounding_ && side <= rounding_) {
    const SurfaceDistance ofCap{cap, capSign * kUp}, ofSide{side, across_ * out - grow_ * kUp};
    const bool capHolds = restsOn(outward, ofCap.gradient), sideHolds = restsOn(outward, ofSide.gradient);
    if (capHolds != sideHolds) return capHolds ? ofCap : ofSide;
    return cap >= side ? ofCap : ofSide;
  }
  if (cap > 0.0 && radius <= (upper ? top_ : bottom_)) return {cap, capSign * kUp};
  if (along >= 0.0 && along <= slant && side > 0.0) return {side, across_ * out - grow_ * kUp};
  // The rim: of the nearer end of the side, or of the cap under the point.
  const auto rimAt = [&](double rimRadius, double y) { return glm::dvec2(radius - rimRadius, p.y - y); };
  const glm::dvec2 atTop = rimAt(top_, halfHeight_), atBottom = rimAt(bottom_, -halfHeight_);
  const bool top = glm::dot(atTop, atTop) <= glm::dot(atBottom, atBottom);
  const glm::dvec2 off = top ? atTop : atBottom;
  const double length = std::hypot(off.x, off.y);
  if (!(length > kTiny)) return {0.0, capSign * kUp};
  return {length, (off.x / length) * out + (off.y / length) * kUp};
}

bool Primitive::edgeNear(const glm::dvec3& inPart, const glm::dvec3& outward, double reach,
                         MeshEdge& edge) const {
  const glm::dvec3 p = shapeFromPart_ * (inPart - centre_);
  const bool found = kind_ == Kind::box        ? boxEdge(p, shapeFromPart_ * outward, reach, edge)
                     : kind_ == Kind::plane    ? planeEdge(p, reach, edge)
                     : kind_ == Kind::cylinder ? rim(p, reach, edge)
                                               : false;
  if (!found) return false;
  edge.a = centre_ + edge.a * shapeFromPart_;
  edge.b = centre_ + edge.b * shapeFromPart_;
  for (glm::dvec3& normal : edge.normals) normal = normal * shapeFromPart_;
  return true;
}

bool Primitive::boxEdge(const glm::dvec3& p, const glm::dvec3& outward, double reach, MeshEdge& edge) const {
  const glm::dvec3 sign(signOf(p.x), signOf(p.y), signOf(p.z)), beyond = glm::abs(p) - half_;
  const std::array<bool, 3> supports = facesToRestOn(outward, sign);
  double least = reach * reach;
  int along = -1;
  for (int k = 0; k < 3; ++k) {
    const double i = beyond[(k + 1) % 3], j = beyond[(k + 2) % 3], end = std::max(0.0, beyond[k]);
    const double square = i * i + j * j + end * end;
    const auto axis = static_cast<std::size_t>(k);
    if (square > least || (!supports[(axis + 1) % 3] && !supports[(axis + 2) % 3])) continue;
    least = square;
    along = k;
  }
  if (along < 0) return false;
  glm::dvec3 first(0.0), second(0.0), foot = sign * half_;
  first[(along + 1) % 3] = sign[(along + 1) % 3];
  second[(along + 2) % 3] = sign[(along + 2) % 3];
  foot[along] = 0.0;
  const double half = half_[along];
  edge = edgeOf(foot, glm::cross(first, second), half, first, second, 0.5 * kPi);
  return true;
}

bool Primitive::planeEdge(const glm::dvec3& p, double reach, MeshEdge& edge) const {
  const double overX = std::abs(p.x) - half_.x, overZ = std::abs(p.z) - half_.z;
  const auto distance = [&](double across, double along) {
    return std::hypot(across, p.y, std::max(0.0, along));
  };
  const double atX = distance(overX, overZ), atZ = distance(overZ, overX);
  if (std::min(atX, atZ) > reach) return false;
  const bool alongZ = atX <= atZ;
  const glm::dvec3 out = alongZ ? glm::dvec3(signOf(p.x), 0.0, 0.0) : glm::dvec3(0.0, 0.0, signOf(p.z));
  const double half = alongZ ? half_.z : half_.x;
  edge = edgeOf(out * half_, glm::cross(kUp, out), half, kUp, -kUp, kPi);
  return true;
}

bool Primitive::rim(const glm::dvec3& p, double reach, MeshEdge& edge) const {
  const double radius = std::hypot(p.x, p.z);
  const double toTop = std::hypot(radius - top_, p.y - halfHeight_),
               toBottom = std::hypot(radius - bottom_, p.y + halfHeight_);
  const bool top = toTop <= toBottom;
  const double of = top ? top_ : bottom_, y = top ? halfHeight_ : -halfHeight_;
  if (std::min(toTop, toBottom) > reach || !(of > 0.0)) return false;
  const glm::dvec3 out = radial(p, radius), cap = top ? kUp : -kUp, side = across_ * out - grow_ * kUp;
  const glm::dvec3 along = glm::cross(cap, out);
  edge = edgeOf(of * out + y * kUp, along, kTangent * of, cap, side,
                std::acos(std::clamp(glm::dot(cap, side), -1.0, 1.0)));
  return true;
}

bool coveredFace(std::span<const Primitive> shapes, std::size_t which, const glm::dvec3& p,
                 const glm::dvec3& inward, const glm::dvec3& outward, double size, glm::dvec3& normal) {
  ASSERT(which < shapes.size());
  // Samples a point beside the edge and slightly above the face, to test whether the face is exposed there.
  const glm::dvec3 above = p + size * inward + 0.1 * size * normal;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (i == which || !shapes[i].solid() || shapes[i].at(above).distance >= 0.0) continue;
    normal = shapes[i].at(p + size * outward).gradient;
    return true;
  }
  return false;
}

std::vector<Primitive> primitivesOf(std::span<const assets::ImplicitShape> shapes, const assets::Mesh& mesh) {
  std::vector<Primitive> primitives;
  for (const assets::ImplicitShape& shape : shapes) {
    const auto& materials = mesh.triangleMaterial;
    const auto at = std::find(materials.begin(), materials.end(), shape.material);
    primitives.emplace_back(shape,
                            at == materials.end() ? 0u : static_cast<std::uint32_t>(at - materials.begin()));
  }
  return primitives;
}

}  // namespace tandem::haptics
