#include "haptics/scene/curved_patch.h"

#include <algorithm>
#include <cmath>

namespace tandem::haptics {
namespace {

// Below this share, squared, of the turn between its normals that bends along an edge, the change of radius
// is not to be seen from it.
constexpr double kLeastBend = 1e-3;

/// m of the header as a series in 1 - cos of the whole angle, right to 1e-3 up to 60 degrees.
double stretchOf(double cosine) {
  const double x = std::clamp(1.0 - cosine, 0.0, 0.5);
  return 1.0 + x * (0.375 + 0.15625 * x);
}

/// An edge from a to b with its two normals.
struct PatchEdge {
  glm::dvec3 first, last;  // control points less those of the straight edge
  glm::dvec3 turn;         // M of the normals

  PatchEdge(const glm::dvec3& edge, const glm::dvec3& a, const glm::dvec3& b, double trustA, double trustB) {
    const double atA = glm::dot(edge, a), atB = -glm::dot(edge, b);
    const double m = stretchOf(glm::dot(a, b));
    first = ((m - 1.0) * edge - m * atA * a) * (trustA / 3.0);
    last = ((1.0 - m) * edge - m * atB * b) * (trustB / 3.0);
    const glm::dvec3 change = b - a;
    const double sum = atA + atB;
    const double whole = sum * sum + kLeastBend * glm::dot(edge, edge) * glm::dot(change, change);
    const double ratio = whole > 0.0 ? 2.0 * (atA - atB) * sum / whole : 0.0;
    turn = std::clamp(ratio, -1.0, 1.0) * change;
  }
};

}  // namespace

CurvedPatch::CurvedPatch(const assets::Mesh& mesh, std::uint32_t t) {
  const auto& c = mesh.triangles[t];
  corner_ = mesh.positions[c[0]];
  edge1_ = u_ = mesh.positions[c[1]] - corner_;
  edge2_ = v_ = mesh.positions[c[2]] - corner_;
  normal_ = facetNormal(mesh, t);
}

CurvedPatch::CurvedPatch(const assets::Mesh& mesh, std::uint32_t t, const CornerNormals& normals,
                         const std::array<double, 3>& trust) {
  const auto& c = mesh.triangles[t];
  const std::array<glm::dvec3, 3> p = {mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]};
  const std::array<glm::dvec3, 3> n = {glm::dvec3(normals[0]), glm::dvec3(normals[1]),
                                       glm::dvec3(normals[2])};
  corner_ = p[0];
  edge1_ = p[1] - p[0];
  edge2_ = p[2] - p[0];
  normal_ = n[0];
  normalU_ = n[1] - n[0];
  normalV_ = n[2] - n[0];
  for (std::size_t i = 0; i < 3; ++i) {
    if (!isApex(normals[i])) continue;
    apex_ = i;
    const std::size_t a = (i + 1) % 3, b = (i + 2) % 3;
    const PatchEdge arc(p[b] - p[a], n[a], n[b], trust[a], trust[b]);
    v_ = p[a] - p[i];
    u_ = p[b] - p[a] + 3.0 * arc.first;
    uu_ = 3.0 * arc.last - 6.0 * arc.first;
    uuu_ = 3.0 * (arc.first - arc.last);
    return;
  }
  // Control points b210, b120, b021, b012, b102, b201 and b111 less the facet's; Bernstein to monomial form.
  const PatchEdge e01(p[1] - p[0], n[0], n[1], trust[0], trust[1]);
  const PatchEdge e12(p[2] - p[1], n[1], n[2], trust[1], trust[2]);
  const PatchEdge e20(p[0] - p[2], n[2], n[0], trust[2], trust[0]);
  const glm::dvec3 &a = e01.first, &b = e01.last, &d = e12.first, &e = e12.last, &f = e20.first,
                   &g = e20.last;
  const glm::dvec3 middle = 0.25 * (a + b + d + e + f + g);
  u_ = edge1_ + 3.0 * a;
  v_ = edge2_ + 3.0 * g;
  uu_ = 3.0 * b - 6.0 * a;
  vv_ = 3.0 * f - 6.0 * g;
  uv_ = 6.0 * (middle - a - g);
  uuu_ = 3.0 * (a - b);
  vvv_ = 3.0 * (g - f);
  uuv_ = 6.0 * a - 3.0 * b + 3.0 * d + 3.0 * g - 6.0 * middle;
  uvv_ = 3.0 * a + 3.0 * e - 3.0 * f + 6.0 * g - 6.0 * middle;
  normalU_ += e01.turn;
  normalV_ += e20.turn;
  normalUU_ = -e01.turn;
  normalVV_ = -e20.turn;
  normalUV_ = e12.turn - e01.turn - e20.turn;
}

/// P = V + s (Q(t) - V), V the apex, s the share of the other two corners, t the ratio within it.
void CurvedPatch::ruledAt(double u, double v, glm::dvec3& point, glm::dvec3& pointU,
                          glm::dvec3& pointV) const {
  const double share[3] = {1.0 - u - v, u, v};
  const std::size_t a = (apex_ + 1) % 3, b = (apex_ + 2) % 3;
  const double s = share[a] + share[b], t = s != 0.0 ? share[b] / s : 0.5;
  const glm::dvec3 ruling = v_ + t * (u_ + t * (uu_ + t * uuu_));
  const glm::dvec3 along = u_ + t * (2.0 * uu_ + 3.0 * t * uuu_);
  const glm::dvec3 apex = apex_ == 0 ? corner_ : apex_ == 1 ? corner_ + edge1_ : corner_ + edge2_;
  point = apex + s * ruling;
  std::array<glm::dvec3, 3> by{};  // derivatives by the three coordinates
  by[a] = ruling - t * along;
  by[b] = ruling + (1.0 - t) * along;
  pointU = by[1] - by[0];
  pointV = by[2] - by[0];
}

}  // namespace tandem::haptics
