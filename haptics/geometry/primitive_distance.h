#pragma once

// Signed distance of a point to an implicit shape by formula, exact but for the rounding of doubles.
//
// 1. The signed distance of a convex solid, negative inside, is a convex function of the point everywhere: a
//    tangent plane of the function lies below it. A plane shape has no inside; its unsigned distance is
//    convex as well.
// 2. No square root of a negative number and no division by zero occurs. Where the gradient is not unique (on
//    an axis, at a centre, along an inner ridge) one of the valid gradients is returned.

#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "assets/scene/scene.h"
#include "haptics/geometry/mesh_edges.h"

namespace tandem::haptics {

struct SurfaceDistance {
  double distance = 0.0;               // m, negative inside
  glm::dvec3 gradient{0.0, 0.0, 0.0};  // unit
};

/// One shape, in the frame of its part.
class Primitive {
 public:
  /// `triangle` is a triangle of its material in the mesh that represents the shape elsewhere
  /// (implicit_mesh.h). A plane must have finite extents.
  explicit Primitive(const assets::ImplicitShape& shape, std::uint32_t triangle = 0);

  SurfaceDistance at(const glm::dvec3& p) const { return against(p, glm::dvec3(0.0)); }
  /// The surface that repels a point of another solid's surface with outward direction `outward` (of any
  /// length; 0 means any direction). Same as at(), except that a face with the same direction never repels,
  /// however slightly p is below it: where two equal boxes lie flush on each other, their edges are nearest
  /// to the sides.
  SurfaceDistance against(const glm::dvec3& p, const glm::dvec3& outward) const;

  /// The sharp convex edge nearest to p, if one is within `reach` m; of a rim, its tangent at the nearest
  /// point; of a box, an edge that can repel a point with outward direction `outward`.
  bool edgeNear(const glm::dvec3& p, const glm::dvec3& outward, double reach, MeshEdge& edge) const;

  /// Whether it has an inside.
  bool solid() const { return kind_ != assets::ImplicitShape::Kind::plane; }
  std::uint32_t triangle() const { return triangle_; }
  /// Upper bound of the magnitude of its coordinates, m, part frame.
  double extent() const { return extent_; }

 private:
  SurfaceDistance ofBox(const glm::dvec3& p, const glm::dvec3& outward) const;
  SurfaceDistance ofPlane(const glm::dvec3& p) const;
  SurfaceDistance ofCapsule(const glm::dvec3& p) const;
  SurfaceDistance ofCylinder(const glm::dvec3& p, const glm::dvec3& outward) const;
  /// In the shape's own frame.
  bool boxEdge(const glm::dvec3& p, const glm::dvec3& outward, double reach, MeshEdge& edge) const;
  bool planeEdge(const glm::dvec3& p, double reach, MeshEdge& edge) const;
  bool rim(const glm::dvec3& p, double reach, MeshEdge& edge) const;

  assets::ImplicitShape::Kind kind_;
  glm::dmat3 shapeFromPart_{1.0};
  glm::dvec3 centre_{0.0, 0.0, 0.0};  // m, part frame
  glm::dvec3 half_{0.0, 0.0, 0.0};    // m, extents of a box or plane
  double halfHeight_ = 0.0;           // m, along Y
  double top_ = 0.0, bottom_ = 0.0;   // m, radii
  double grow_ = 0.0;    // m per m of height: growth of the spheres that touch the side from inside
  double across_ = 1.0;  // sqrt(1 - grow^2): the side's normal is (across, -grow)
  double extent_ = 0.0, rounding_ = 0.0;  // m
  std::uint32_t triangle_ = 0;
};

/// Whether another shape of the part covers the face of shape `which` that ends at p, on its edge. `normal`
/// is the face's normal, `inward` the unit direction from the edge into the face, `size` (m) the extent that
/// is tested. On true, `normal` becomes that of the covering face, which meets the edge from outside with
/// outward direction `outward`.
bool coveredFace(std::span<const Primitive> shapes, std::size_t which, const glm::dvec3& p,
                 const glm::dvec3& inward, const glm::dvec3& outward, double size, glm::dvec3& normal);

/// The primitives of all shapes of a part. `mesh` is what meshOfShapes() makes of them, for their materials.
std::vector<Primitive> primitivesOf(std::span<const assets::ImplicitShape> shapes, const assets::Mesh& mesh);

}  // namespace tandem::haptics
