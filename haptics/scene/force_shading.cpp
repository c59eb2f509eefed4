#include "haptics/scene/force_shading.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

using assets::kNone;
using assets::Mesh;

constexpr int kMaxNewton = 6;
constexpr int kMaxSteps = 12;  // from triangle to triangle
// Last step of Newton's iteration, in triangles: the next would be its square, and the derivatives, which are
// those before it, are off by less than that share of the facet's turn.
constexpr double kConverged = 1e-5;
constexpr double kOutside = 1e-7;  // fraction of a triangle by which a point may lie beyond an edge
constexpr double kTooFar = 0.5;    // fraction of a triangle beyond a crease, where the patch ends
constexpr double kFurthest = 1.0;  // triangles beyond its own to which a patch is extended
// Fraction of the patch's area left on its offset surface below which normals are about to cross: 97 % of the
// radius of curvature.
constexpr double kFold = 1e-3;
// Depth times curvature at which shading begins to fade, and at which the facets alone are felt.
constexpr double kFadeBegin = 0.82, kFadeEnd = 0.95;
// A force along normals that converge turns faster than it grows: over that of a spring it changes by
// d / (1 - d), d its depth times the curvature. From where shading fades, at most as at the end of that.
constexpr double kSteepest = 1.0 / (1.0 - kFadeEnd);

CurvedPatch patchOf(const Mesh& mesh, const ShadedMesh& shaded, std::uint32_t t) {
  const std::array<CornerBend, 3>& bends = shaded.bends[t];
  return CurvedPatch(mesh, t, shaded.normals[t],
                     {bends[0].trust / 65535.0, bends[1].trust / 65535.0, bends[2].trust / 65535.0});
}

/// Newton's iteration for point(u, v) - depth * side * normal(u, v) = p. `first` becomes the point where it
/// starts. False where the patch folds.
bool solve(const CurvedPatch& patch, const glm::dvec3& p, double side, PatchPoint& x, glm::dvec3& first) {
  for (int i = 0; i < kMaxNewton; ++i) {
    glm::dvec3 n, nU, nV;
    patch.at(x.u, x.v, x.point, x.pointU, x.pointV);
    if (i == 0) first = x.point;
    patch.normalAt(x.u, x.v, n, nU, nV);
    x.normal = side * n;
    const glm::dvec3 a = x.pointU - x.depth * side * nU, b = x.pointV - x.depth * side * nV;
    const glm::dvec3 c = glm::cross(a, b);
    const double volume = glm::dot(c, n);
    // Past a centre of curvature both sides have turned, and the volume is positive again.
    if (!(glm::dot(a, x.pointU) > 0.0 && glm::dot(b, x.pointV) > 0.0)) return false;
    if (!(volume > kFold * glm::length(glm::cross(x.pointU, x.pointV)))) return false;
    x.uGradient = glm::cross(b, n) / volume;
    x.vGradient = glm::cross(n, a) / volume;
    x.depthGradient = -side * c / volume;
    const glm::dvec3 error = p - (x.point - x.depth * x.normal);
    const double du = glm::dot(x.uGradient, error), dv = glm::dot(x.vGradient, error);
    x.depth += glm::dot(x.depthGradient, error);
    x.u = std::clamp(x.u + du, -kFurthest, 1.0 + kFurthest);
    x.v = std::clamp(x.v + dv, -kFurthest, 1.0 + kFurthest);
    if (std::abs(du) + std::abs(dv) < kConverged) return true;
  }
  return true;
}

void setStart(const Mesh& mesh, std::uint32_t t, const glm::dvec3& start, PatchPoint& x) {
  const auto& c = mesh.triangles[t];
  const glm::dvec3 e1 = mesh.positions[c[1]] - mesh.positions[c[0]],
                   e2 = mesh.positions[c[2]] - mesh.positions[c[0]];
  const glm::dvec3 r = start - mesh.positions[c[0]];
  const double d11 = glm::dot(e1, e1), d12 = glm::dot(e1, e2), d22 = glm::dot(e2, e2);
  const double determinant = d11 * d22 - d12 * d12;
  const double scale = determinant > 0.0 ? 1.0 / determinant : 0.0;
  x.u = (d22 * glm::dot(r, e1) - d12 * glm::dot(r, e2)) * scale;
  x.v = (d11 * glm::dot(r, e2) - d12 * glm::dot(r, e1)) * scale;
  x.triangle = t;
}

/// The corner from which the point has moved furthest, beyond the opposite edge; 3 = the point is in the
/// triangle.
std::size_t cornerLeft(const PatchPoint& x, double& share) {
  const double b[3] = {1.0 - x.u - x.v, x.u, x.v};
  const std::size_t i = static_cast<std::size_t>(std::min_element(b, b + 3) - b);
  share = b[i];
  return b[i] < -kOutside ? i : 3;
}

std::array<double, 3> barycentric(const PatchPoint& x) {
  const double u = std::clamp(x.u, 0.0, 1.0), v = std::clamp(x.v, 0.0, 1.0 - u);
  return {1.0 - u - v, u, v};
}

/// Depth times the curvature on the side of the query point. Curvature grows inversely to the distance from
/// an apex.
double depthTimesCurvature(const ShadedMesh& shaded, const PatchPoint& x, double side) {
  const std::array<double, 3> share = barycentric(x);
  const bool front = (x.depth > 0.0) == (side > 0.0);
  double curvature = 0.0, away = 1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const CornerBend& bend = shaded.bends[x.triangle][i];
    if (isApex(shaded.normals[x.triangle][i])) {
      away = 1.0 - share[i];
    } else {
      curvature += share[i] * unpackCurvature(front ? bend.convex : bend.concave);
    }
  }
  return away > 0.0 ? std::abs(x.depth) * curvature / (away * away) : 1.0;
}

/// How far the normals at x are a surface's.
double trustAt(const ShadedMesh& shaded, const PatchPoint& x) {
  const std::array<double, 3> share = barycentric(x);
  const std::array<CornerBend, 3>& bends = shaded.bends[x.triangle];
  return (share[0] * bends[0].trust + share[1] * bends[1].trust + share[2] * bends[2].trust) / 65535.0;
}

}  // namespace

std::uint16_t packCurvature(double value) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(static_cast<float>(std::min(value, 1e30)));
  return static_cast<std::uint16_t>((bits >> 16) + (value > 0.0 ? 1 : 0));
}

double unpackCurvature(std::uint16_t packed) {
  return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(packed) << 16));
}

bool smoothTogether(const ShadedMesh& shaded, const Mesh& mesh, std::uint32_t a, std::uint32_t b) {
  if (shaded.region[a] != shaded.region[b]) return false;
  if (mesh.neighbours.size() != mesh.triangles.size()) return true;
  for (std::size_t e = 0; e < 3; ++e)
    if (mesh.neighbours[a][e] == b && shaded.smoothAcross[a][e] == kNone) return false;
  return true;
}

double facetTurn(const Mesh& mesh, const ShadedMesh& shaded, std::uint32_t triangle) {
  const glm::dvec3 facet = facetNormal(mesh, triangle);
  double least = 1.0;
  for (const glm::vec3& n : shaded.normals[triangle])
    if (!isApex(n)) least = std::min(least, glm::dot(glm::dvec3(n), facet));
  return std::acos(std::clamp(least, -1.0, 1.0));
}

bool projectOntoPatch(const Mesh& mesh, const ShadedMesh* shaded, std::uint32_t triangle,
                      const glm::dvec3& start, const glm::dvec3& p, double side, PatchPoint& x) {
  ASSERT(triangle < mesh.triangles.size());
  setStart(mesh, triangle, start, x);
  const glm::dvec3 facet = side * facetNormal(mesh, triangle);
  x.depth = glm::dot(start - p, facet);
  if (shaded == nullptr) {
    glm::dvec3 first;
    return solve(CurvedPatch(mesh, triangle), p, side, x, first);
  }
  x.trust = trustAt(*shaded, x);
  std::uint32_t previous = kNone;
  double beyond = 0.0;
  for (int step = 0; step < kMaxSteps; ++step) {
    glm::dvec3 first;
    const bool unfolded = solve(patchOf(mesh, *shaded, x.triangle), p, side, x, first);
    if (step == 0) x.relief = std::max(0.0, glm::dot(first - start, facet));
    if (!unfolded) return false;
    const std::size_t left = cornerLeft(x, beyond);
    const std::uint32_t next = left == 3 ? kNone : shaded->smoothAcross[x.triangle][(left + 1) % 3];
    // Rounding may send the point across an edge from both sides; either result is right there.
    if (next == kNone || next == previous) break;
    previous = x.triangle;
    setStart(mesh, next, x.point, x);
  }
  const double bent = depthTimesCurvature(*shaded, x, side);
  x.share = 1.0 - glm::smoothstep(kFadeBegin, kFadeEnd, bent);
  x.steepness = bent < kFadeBegin ? std::max(1.0, bent / (1.0 - bent)) : kSteepest;
  return beyond > -kTooFar;
}

}  // namespace tandem::haptics
