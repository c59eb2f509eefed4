#include "haptics/scene/force_shading.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/geometry/triangle_math.h"

namespace tandem::haptics {
namespace {

using assets::kNone;
using assets::Mesh;

constexpr int kMaxNewton = 6;
constexpr int kMaxSteps = 12;        // from triangle to triangle
constexpr double kConverged = 1e-9;  // fraction of a triangle
constexpr double kOutside = 1e-7;    // fraction of a triangle by which a point may lie beyond an edge
constexpr double kTooFar = 0.5;      // fraction of a triangle beyond a crease, where the patch ends
// Fraction of the patch's area left on its offset surface below which normals are about to cross: 97 % of the
// radius of curvature.
constexpr double kFold = 1e-3;

using Across = std::vector<std::array<std::uint32_t, 3>>;

/// Computes the neighbours of a mesh that has none.
Across findNeighbours(const Mesh& mesh) {
  Across across(mesh.triangles.size(), {kNone, kNone, kNone});
  std::unordered_map<std::uint64_t, std::uint32_t> open;  // directed edge to 3 * triangle + edge
  const auto key = [](std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t a = mesh.triangles[t][e], b = mesh.triangles[t][(e + 1) % 3];
      const auto other = open.find(key(b, a));
      if (other == open.end()) {
        open.emplace(key(a, b), 3 * t + e);
        continue;
      }
      across[t][e] = other->second / 3;
      across[other->second / 3][other->second % 3] = t;
      open.erase(other);
    }
  }
  return across;
}

glm::dvec3 facetNormal(const Mesh& mesh, std::uint32_t t) {
  const auto& c = mesh.triangles[t];
  const glm::dvec3 n = areaVector({mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]});
  const double length = glm::length(n);
  return length > 0.0 ? n / length : glm::dvec3(0.0);
}

/// Union-find of corners that share a normal; corner = 3 * triangle + its place.
class Groups {
 public:
  explicit Groups(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t root(std::uint32_t c) {
    while (parent_[c] != c) c = parent_[c] = parent_[parent_[c]];
    return c;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// Weight and direction of one facet at one of its corners (Max 1999): sin(angle) / (product of the two
/// edges), which is cross / (|a|^2 |b|^2).
glm::dvec3 weighted(const Mesh& mesh, std::uint32_t t, std::size_t corner) {
  const auto& c = mesh.triangles[t];
  const glm::dvec3& at = mesh.positions[c[corner]];
  const glm::dvec3 a = mesh.positions[c[(corner + 1) % 3]] - at, b = mesh.positions[c[(corner + 2) % 3]] - at;
  const double squares = glm::dot(a, a) * glm::dot(b, b);
  return squares > 0.0 ? glm::cross(a, b) / squares : glm::dvec3(0.0);
}

double creaseAt(const Mesh& mesh, std::span<const double> creaseOf, std::uint32_t t) {
  if (t >= mesh.triangleMaterial.size()) return 0.0;
  const std::uint16_t material = mesh.triangleMaterial[t];
  return material < creaseOf.size() ? creaseOf[material] : 0.0;
}

/// Clears the neighbours across edges that must stay sharp, and joins the corners along the others.
void joinAcrossSmoothEdges(const Mesh& mesh, std::span<const double> creaseOf, Across& across,
                           Groups& groups) {
  for (std::uint32_t t = 0; t < across.size(); ++t) {
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t n = across[t][e];
      if (n == kNone) continue;
      const double crease = std::min(creaseAt(mesh, creaseOf, t), creaseAt(mesh, creaseOf, n));
      const std::uint32_t a = mesh.triangles[t][e], b = mesh.triangles[t][(e + 1) % 3];
      const auto& other = mesh.triangles[n];
      const std::size_t atA =
          static_cast<std::size_t>(std::find(other.begin(), other.end(), a) - other.begin());
      const std::size_t atB =
          static_cast<std::size_t>(std::find(other.begin(), other.end(), b) - other.begin());
      const bool agrees = atA < 3 && atB < 3 && (atB + 1) % 3 == atA;
      if (!agrees || !(glm::dot(facetNormal(mesh, t), facetNormal(mesh, n)) >= std::cos(crease)) ||
          crease == 0.0) {
        across[t][e] = kNone;
        continue;
      }
      groups.join(3 * t + e, 3 * n + static_cast<std::uint32_t>(atA));
      groups.join(3 * t + (e + 1) % 3, 3 * n + static_cast<std::uint32_t>(atB));
    }
  }
}

/// A triangle's patch by Phong tessellation with weight 1/2 (Boubekeur & Alexa 2008): flat point p, and P = p
/// + 1/2 sum b_i ((V_i - p) . N_i) N_i.
struct Patch {
  std::array<glm::dvec3, 3> corner, normal;

  Patch(const Mesh& mesh, const ShadedMesh* shaded, std::uint32_t t) {
    for (std::size_t i = 0; i < 3; ++i) corner[i] = mesh.positions[mesh.triangles[t][i]];
    const glm::dvec3 facet = shaded == nullptr ? facetNormal(mesh, t) : glm::dvec3(0.0);
    for (std::size_t i = 0; i < 3; ++i)
      normal[i] = shaded == nullptr ? facet : glm::dvec3(shaded->normals[t][i]);
  }

  void at(double u, double v, glm::dvec3& point, glm::dvec3& pointU, glm::dvec3& pointV) const {
    const double b[3] = {1.0 - u - v, u, v};
    pointU = corner[1] - corner[0];
    pointV = corner[2] - corner[0];
    const glm::dvec3 flat = corner[0] + u * pointU + v * pointV;
    glm::dvec3 lift(0.0), liftU(0.0), liftV(0.0);
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3& n = normal[i];
      const double height = glm::dot(corner[i] - flat, n);
      const double du = i == 0 ? -1.0 : i == 1 ? 1.0 : 0.0, dv = i == 0 ? -1.0 : i == 2 ? 1.0 : 0.0;
      lift += b[i] * height * n;
      liftU += (du * height - b[i] * glm::dot(pointU, n)) * n;
      liftV += (dv * height - b[i] * glm::dot(pointV, n)) * n;
    }
    point = flat + 0.5 * lift;
    pointU += 0.5 * liftU;
    pointV += 0.5 * liftV;
  }

  void normalAt(double u, double v, glm::dvec3& n, glm::dvec3& nU, glm::dvec3& nV) const {
    const glm::dvec3 mU = normal[1] - normal[0], mV = normal[2] - normal[0];
    const glm::dvec3 m = normal[0] + u * mU + v * mV;
    const double length = glm::length(m);
    const double scale = length > 0.0 ? 1.0 / length : 0.0;
    n = m * scale;
    nU = (mU - n * glm::dot(n, mU)) * scale;
    nV = (mV - n * glm::dot(n, mV)) * scale;
  }
};

/// Newton's iteration for point(u, v) - depth * side * normal(u, v) = p. False where the patch folds.
bool solve(const Patch& patch, const glm::dvec3& p, double side, PatchPoint& x) {
  for (int i = 0; i < kMaxNewton; ++i) {
    glm::dvec3 n, nU, nV;
    patch.at(x.u, x.v, x.point, x.pointU, x.pointV);
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
    if (std::abs(du) + std::abs(dv) < kConverged) return true;
    x.u += du;
    x.v += dv;
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

}  // namespace

ShadedMesh shadeMesh(const Mesh& mesh, std::span<const double> creaseOf) {
  ShadedMesh out;
  const std::size_t count = mesh.triangles.size();
  out.smoothAcross = mesh.neighbours.size() == count ? mesh.neighbours : findNeighbours(mesh);
  Groups groups(3 * count);
  joinAcrossSmoothEdges(mesh, creaseOf, out.smoothAcross, groups);
  std::vector<glm::dvec3> sum(3 * count, glm::dvec3(0.0));
  for (std::uint32_t t = 0; t < count; ++t)
    for (std::uint32_t c = 0; c < 3; ++c) sum[groups.root(3 * t + c)] += weighted(mesh, t, c);
  out.normals.resize(count);
  for (std::uint32_t t = 0; t < count; ++t) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const glm::dvec3& s = sum[groups.root(3 * t + c)];
      const double length = glm::length(s);
      const glm::dvec3 facet = facetNormal(mesh, t);
      // Facets that cancel at a corner leave no direction; each keeps its own.
      const bool usable = length > 0.0 && glm::dot(s, facet) > 0.1 * length;
      out.normals[t][c] = glm::vec3(usable ? s / length : facet);
    }
    const Patch patch(mesh, &out, t);
    const double places[4][2] = {{1.0 / 3.0, 1.0 / 3.0}, {0.5, 0.0}, {0.0, 0.5}, {0.5, 0.5}};
    for (const auto& [u, v] : places) {
      glm::dvec3 point, pu, pv;
      patch.at(u, v, point, pu, pv);
      const glm::dvec3 flat = (1.0 - u - v) * patch.corner[0] + u * patch.corner[1] + v * patch.corner[2];
      out.relief = std::max(out.relief, 1.5 * glm::length(point - flat));
    }
  }
  return out;
}

bool projectOntoPatch(const Mesh& mesh, const ShadedMesh* shaded, std::uint32_t triangle,
                      const glm::dvec3& start, const glm::dvec3& p, double side, PatchPoint& x) {
  ASSERT(triangle < mesh.triangles.size());
  setStart(mesh, triangle, start, x);
  x.depth = glm::dot(start - p, side * facetNormal(mesh, triangle));
  std::uint32_t previous = kNone;
  double beyond = 0.0;
  for (int step = 0; step < kMaxSteps; ++step) {
    if (!solve(Patch(mesh, shaded, x.triangle), p, side, x)) return false;
    const std::size_t left = cornerLeft(x, beyond);
    if (left == 3 || shaded == nullptr) return true;
    const std::uint32_t next = shaded->smoothAcross[x.triangle][(left + 1) % 3];
    // Rounding may send the point across an edge from both sides; either result is right there.
    if (next == kNone || next == previous) return beyond > -kTooFar;
    previous = x.triangle;
    setStart(mesh, next, x.point, x);
  }
  return beyond > -kTooFar;
}

}  // namespace tandem::haptics
