#pragma once

// How far a point is from an implicit shape, by formula: exact but for the rounding of doubles.
//
// 1. The signed distance of a convex solid, below 0 inside, is a convex function of the point everywhere: a plane
//    that touches it in one place lies below it in all others. A plane shape has no inside; its unsigned distance is
//    convex as well.
// 2. No square root of a negative number, no division by zero: where the gradient is not unique it is one of
//    those that are (on an axis, at a centre, along a ridge of the inside).

#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "assets/scene/scene.h"
#include "haptics/geometry/mesh_edges.h"

namespace tandem::haptics {

struct SurfaceDistance {
  double distance = 0.0;               // m, below 0 inside
  glm::dvec3 gradient{0.0, 0.0, 0.0};  // unit
};

/// One shape, in the frame of its part.
class Primitive {
 public:
  /// `triangle`: one of its material in the mesh that stands for it elsewhere (implicit_mesh.h). A plane must have
  /// finite extents.
  explicit Primitive(const assets::ImplicitShape& shape, std::uint32_t triangle = 0);

  SurfaceDistance at(const glm::dvec3& p) const { return against(p, glm::dvec3(0.0)); }
  /// What holds off a place of another solid's surface that looks along `outward` (of any length, 0: any way). As at(), but
  /// no face holds it off that looks the same way, however little below it p is: where two boxes of one size lie flush on
  /// each other, their edges are nearest to the sides.
  SurfaceDistance against(const glm::dvec3& p, const glm::dvec3& outward) const;

  /// The sharp convex edge nearest to p, if one is within `reach` m; of a rim its tangent where it is nearest. Of a box one
  /// that can hold off a place that looks along `outward`.
  bool edgeNear(const glm::dvec3& p, const glm::dvec3& outward, double reach, MeshEdge& edge) const;

  /// Whether it has an inside.
  bool solid() const { return kind_ != assets::ImplicitShape::Kind::plane; }
  std::uint32_t triangle() const { return triangle_; }
  /// The largest coordinate of its box by magnitude, at most this, m, part frame.
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
  glm::dvec3 centre_{0.0, 0.0, 0.0};      // m, part frame
  glm::dvec3 half_{0.0, 0.0, 0.0};        // m, extents of a box or plane
  double halfHeight_ = 0.0;               // m, along Y
  double top_ = 0.0, bottom_ = 0.0;       // m, radii
  double grow_ = 0.0;                     // m a m of height: of the spheres that touch the side from inside
  double across_ = 1.0;                   // sqrt(1 - grow^2): the side's normal is (across, -grow)
  double extent_ = 0.0, rounding_ = 0.0;  // m
  std::uint32_t triangle_ = 0;
};

/// What is seen of a part of several shapes where one of them has a face that ends at p, on its edge. `normal`: of the
/// face, `inward`: from the edge into it, unit. True where another shape lies on the face there; `normal` is then that
/// of the other one, which meets the edge from outside, looking along `outward`. `size`: m, of what is looked at.
bool coveredFace(std::span<const Primitive> shapes, std::size_t which, const glm::dvec3& p,
                 const glm::dvec3& inward, const glm::dvec3& outward, double size, glm::dvec3& normal);

/// Of all shapes of a part. `mesh`: what meshOfShapes() makes of them, for their materials.
std::vector<Primitive> primitivesOf(std::span<const assets::ImplicitShape> shapes, const assets::Mesh& mesh);

}  // namespace tandem::haptics
