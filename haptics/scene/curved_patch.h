#pragma once

// The curved patch over one facet: a cubic through its corners that is normal to the corners' normals.
//
// Source: PN triangles, Vlachos, Peters, Boyd & Mitchell 2001, "Curved PN triangles". Control points of the
// edges lie in the corners' tangent planes, the middle one gives quadratic precision. Deviations:
// 1. A control point stands farther from its corner by m = 2 / (C (1 + C)), C the cosine of half the angle
//    between the edge's two normals, with which the middle of an arc of a circle is exact.
// 2. Normals are interpolated by b_i N_i + b_i b_j c_ij (N_j - N_i): c is the relative change of the radius
//    of curvature along the edge, by which the normal turns faster at its narrow end, as it does on a cone.
//    Of the edge E and the heights h_i = N_i . E, h_j = -N_j . E of its ends over their tangent planes,
//    c = 2 (h_i - h_j) / (h_i + h_j).
// 3. A corner without a normal is the apex of a cone: the patch is ruled from it.

#include <array>
#include <cstdint>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "assets/scene/scene.h"
#include "haptics/geometry/triangle_math.h"

namespace tandem::haptics {

using CornerNormals = std::array<glm::vec3, 3>;  // unit; zero: the apex of a cone

inline bool isApex(const glm::vec3& normal) { return normal == glm::vec3(0.0f); }

/// Unit normal of a facet; zero where it has no area.
inline glm::dvec3 facetNormal(const assets::Mesh& mesh, std::uint32_t t) {
  const auto& c = mesh.triangles[t];
  const glm::dvec3 n = areaVector({mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]});
  const double length = glm::length(n);
  return length > 0.0 ? n / length : glm::dvec3(0.0);
}

/// u and v are the barycentric coordinates of corners 1 and 2. At most one corner may be an apex.
class CurvedPatch {
 public:
  /// `trust`: share of the curve at each corner, 0 = as flat as the facet.
  CurvedPatch(const assets::Mesh& mesh, std::uint32_t t, const CornerNormals& normals,
              const std::array<double, 3>& trust);

  /// The facet itself.
  CurvedPatch(const assets::Mesh& mesh, std::uint32_t t);

  void at(double u, double v, glm::dvec3& point, glm::dvec3& pointU, glm::dvec3& pointV) const {
    if (apex_ < 3) return ruledAt(u, v, point, pointU, pointV);
    point = corner_ + u * (u_ + u * (uu_ + u * uuu_ + v * uuv_) + v * (uv_ + v * uvv_)) +
            v * (v_ + v * (vv_ + v * vvv_));
    pointU = u_ + u * (2.0 * uu_ + 3.0 * u * uuu_ + 2.0 * v * uuv_) + v * (uv_ + v * uvv_);
    pointV = v_ + v * (2.0 * vv_ + 3.0 * v * vvv_ + 2.0 * u * uvv_) + u * (uv_ + u * uuv_);
  }

  void normalAt(double u, double v, glm::dvec3& n, glm::dvec3& nU, glm::dvec3& nV) const {
    const glm::dvec3 mU = normalU_ + 2.0 * u * normalUU_ + v * normalUV_;
    const glm::dvec3 mV = normalV_ + 2.0 * v * normalVV_ + u * normalUV_;
    const glm::dvec3 m =
        normal_ + u * (normalU_ + u * normalUU_) + v * (normalV_ + v * normalVV_ + u * normalUV_);
    const double length = glm::length(m);
    const double scale = length > 0.0 ? 1.0 / length : 0.0;
    n = m * scale;
    nU = (mU - n * glm::dot(n, mU)) * scale;
    nV = (mV - n * glm::dot(n, mV)) * scale;
  }

  /// The point of the facet with these coordinates.
  glm::dvec3 facetAt(double u, double v) const { return corner_ + u * edge1_ + v * edge2_; }

 private:
  void ruledAt(double u, double v, glm::dvec3& point, glm::dvec3& pointU, glm::dvec3& pointV) const;

  glm::dvec3 corner_, edge1_, edge2_;
  // Coefficients of the monomials; from an apex, u_, uu_ and uuu_ are those of the arc opposite, from v_ on.
  glm::dvec3 u_{0.0}, v_{0.0}, uu_{0.0}, uv_{0.0}, vv_{0.0}, uuu_{0.0}, uuv_{0.0}, uvv_{0.0}, vvv_{0.0};
  glm::dvec3 normal_, normalU_{0.0}, normalV_{0.0}, normalUU_{0.0}, normalUV_{0.0}, normalVV_{0.0};
  std::size_t apex_ = 3;  // the corner; 3 = none
};

}  // namespace tandem::haptics
