#include "haptics/scene/corner_normals.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "assets/base/buckets.h"
#include "assets/base/disjoint_sets.h"
#include "assets/scene/smooth_normals.h"
#include "haptics/scene/quadric_normal.h"

namespace tandem::haptics {
namespace {

using assets::kNone;
using assets::Mesh;

// Facets around an apex turn away from it by less than this share, squared, of their turn about it.
constexpr double kRuled = 0.02;
constexpr std::uint32_t kLeastFan = 8;  // facets: the corners of meshes of round shapes have fewer
constexpr double kAllAround = 0.5;      // 1 for a round cone, 0 for a cylinder
constexpr double kLeastTurn = 1e-6;     // rad^2, below which a corner is flat
// Neighbours of a corner from which its normal is fitted.
constexpr std::size_t kMaxAround = 48;
// How far edges are from standing symmetrically on their two normals, relative to the turn of the normals:
// below kSurface the normals are a surface's, above kNoise they are noise. Between them a change of curvature
// explains it where the vertices lie on a quadric.
constexpr double kLeastNoise = 1e-10;  // rad^2, the rounding of the vertices
constexpr double kSurface = 0.03, kNoise = 0.3, kUnexplained = 0.12;

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

/// Weight and direction of one facet at one of its corners (Max 1999): sin(angle) / (product of the two
/// edges), which is cross / (|a|^2 |b|^2).
glm::dvec3 weighted(const Mesh& mesh, std::uint32_t t, std::size_t corner) {
  const auto& c = mesh.triangles[t];
  const glm::dvec3& at = mesh.positions[c[corner]];
  const glm::dvec3 a = mesh.positions[c[(corner + 1) % 3]] - at, b = mesh.positions[c[(corner + 2) % 3]] - at;
  const double squares = glm::dot(a, a) * glm::dot(b, b);
  return squares > 0.0 ? glm::cross(a, b) / squares : glm::dvec3(0.0);
}

class MeshShader {
 public:
  MeshShader(const Mesh& mesh, std::span<const double> creaseOf) : mesh_(mesh), creaseOf_(creaseOf) {}

  ShadedMesh shade() {
    out_.smoothAcross =
        mesh_.neighbours.size() == mesh_.triangles.size() ? mesh_.neighbours : findNeighbours(mesh_);
    facets_.resize(mesh_.triangles.size());
    for (std::uint32_t t = 0; t < facets_.size(); ++t) facets_[t] = facetNormal(mesh_, t);
    keepSmoothEdges();
    findApices();
    joinCorners();
    setNormals();
    setRegions();
    setBends();
    return std::move(out_);
  }

 private:
  std::uint32_t count() const { return static_cast<std::uint32_t>(mesh_.triangles.size()); }
  const glm::dvec3& place(std::uint32_t t, std::size_t corner) const {
    return mesh_.positions[mesh_.triangles[t][corner % 3]];
  }

  double creaseAt(std::uint32_t t) const {
    if (t >= mesh_.triangleMaterial.size()) return 0.0;
    const std::uint16_t material = mesh_.triangleMaterial[t];
    const double crease = material < creaseOf_.size() ? creaseOf_[material] : 0.0;
    return crease < 0.0 && mesh_.triangleNormal.size() != mesh_.triangles.size() ? 0.0 : crease;
  }

  glm::dvec3 fileNormal(std::uint32_t t, std::size_t corner) const {
    return glm::dvec3(mesh_.triangleNormal[t][corner % 3]);
  }

  /// The corner of triangle n at vertex v; 3 if it has none.
  std::size_t cornerAt(std::uint32_t n, std::uint32_t v) const {
    const auto& c = mesh_.triangles[n];
    return static_cast<std::size_t>(std::find(c.begin(), c.end(), v) - c.begin());
  }

  /// Whether the file's normals at a vertex agree on both sides of an edge between facets t and n.
  bool agree(std::uint32_t t, std::size_t at, std::uint32_t n, std::size_t other) const {
    return assets::agreeAcross(fileNormal(t, at), fileNormal(n, other), facets_[t], facets_[n]);
  }

  /// Clears the neighbours across edges that stay sharp. Edges at a vertex that may be an apex wait for
  /// findApices().
  void keepSmoothEdges() {
    pending_.assign(count(), {});
    for (std::uint32_t t = 0; t < count(); ++t) {
      for (std::uint32_t e = 0; e < 3; ++e) {
        std::uint32_t& n = out_.smoothAcross[t][e];
        if (n == kNone) continue;
        const double own = creaseAt(t), others = creaseAt(n);
        const std::size_t atA = cornerAt(n, mesh_.triangles[t][e]);
        const std::size_t atB = cornerAt(n, mesh_.triangles[t][(e + 1) % 3]);
        bool smooth = atA < 3 && atB < 3 && (atB + 1) % 3 == atA;
        if (own > 0.0 && others > 0.0) {
          smooth = smooth && glm::dot(facets_[t], facets_[n]) >= std::cos(std::min(own, others));
        } else if (own < 0.0 && others < 0.0 && smooth) {
          const bool a = agree(t, e, n, atA), b = agree(t, e + 1, n, atB);
          smooth = a || b;
          if (a != b) pending_[t][e] = a ? 2 : 1;  // 1 + the place, from the edge's start, that disagrees
        } else {
          smooth = false;
        }
        if (!smooth) n = kNone;
      }
    }
  }

  /// What shows whether the facets around a vertex are those of an apex.
  struct Fan {
    glm::dvec3 sum{0.0};
    glm::dmat3 squares{0.0};
    double away = 0.0;  // squared turn away from the vertex
    std::uint32_t corners = 0, measured = 0;
    bool closed = true, shaded = false;
  };

  Fan addToFan(Fan fan, std::uint32_t t, std::uint32_t c) const {
    const double crease = creaseAt(t);
    fan.sum += facets_[t];
    fan.squares += glm::outerProduct(facets_[t], facets_[t]);
    ++fan.corners;
    fan.shaded = fan.shaded || crease != 0.0;
    fan.closed = fan.closed && out_.smoothAcross[t][c] != kNone && out_.smoothAcross[t][(c + 2) % 3] != kNone;
    if (crease < 0.0) {
      const glm::dvec3 ruling = glm::normalize(place(t, c + 1) - place(t, c));
      const double tilt = glm::dot(ruling, fileNormal(t, c + 1));
      fan.away += tilt * tilt;
      ++fan.measured;
    } else if (const std::uint32_t n = out_.smoothAcross[t][(c + 1) % 3]; n != kNone) {
      const glm::dvec3 turn = facets_[n] - facets_[t];
      fan.away += glm::dot(turn, turn);
      ++fan.measured;
    }
    return fan;
  }

  static bool isRuled(const Fan& fan) {
    if (!fan.shaded || !fan.closed || fan.corners < kLeastFan) return false;
    const double n = fan.corners;
    const glm::dvec3 mean = fan.sum / n;
    const glm::dmat3 spread = fan.squares / n - glm::outerProduct(mean, mean);
    const double about = spread[0][0] + spread[1][1] + spread[2][2];
    if (!(about > kLeastTurn && fan.away <= kRuled * about * std::max(1u, fan.measured))) return false;
    // The facets turn about the vertex in every direction, those of a cylinder in one.
    double squares = 0.0;
    for (int i = 0; i < 3; ++i) squares += glm::dot(spread[i], spread[i]);
    return 2.0 * (about * about - squares) > kAllAround * about * about;
  }

  void findApices() {
    std::vector<Fan> fans(mesh_.positions.size());
    for (std::uint32_t t = 0; t < count(); ++t)
      for (std::uint32_t c = 0; c < 3; ++c) {
        Fan& fan = fans[mesh_.triangles[t][c]];
        fan = addToFan(fan, t, c);
      }
    apex_.resize(fans.size());
    for (std::size_t v = 0; v < fans.size(); ++v) apex_[v] = isRuled(fans[v]);
    for (std::uint32_t t = 0; t < count(); ++t)
      for (std::uint32_t e = 0; e < 3; ++e)
        if (pending_[t][e] != 0 && !apex_[mesh_.triangles[t][(e + pending_[t][e] - 1) % 3]])
          out_.smoothAcross[t][e] = kNone;
  }

  void joinCorners() {
    DisjointSets groups(3 * std::size_t{count()});
    for (std::uint32_t t = 0; t < count(); ++t)
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t n = out_.smoothAcross[t][e];
        if (n == kNone) continue;
        for (const std::uint32_t c : {e, (e + 1) % 3})
          groups.join(3 * t + c, 3 * n + static_cast<std::uint32_t>(cornerAt(n, mesh_.triangles[t][c])));
      }
    root_.resize(3 * std::size_t{count()});
    for (std::uint32_t i = 0; i < root_.size(); ++i) root_[i] = groups.find(i);
  }

  void setNormals() {
    corners_ = Buckets(root_.size(), [&](const auto& add) {
      for (std::uint32_t i = 0; i < root_.size(); ++i) add(root_[i], i);
    });
    fits_.assign(root_.size(), false);
    out_.normals.resize(count());
    for (std::uint32_t r = 0; r < root_.size(); ++r) {
      if (corners_[r].empty()) continue;
      const bool estimate = creaseAt(r / 3) > 0.0;
      const glm::dvec3 shared = estimate ? estimatedNormal(r) : glm::dvec3(0.0);
      for (const std::uint32_t corner : corners_[r]) {
        const std::uint32_t t = corner / 3, c = corner % 3;
        glm::dvec3 normal = estimate ? shared : creaseAt(t) < 0.0 ? fileNormal(t, c) : facets_[t];
        // Facets that cancel at a corner leave no direction; each keeps its own.
        if (estimate && !(glm::dot(shared, facets_[t]) > 0.1)) normal = facets_[t];
        if (apex_[mesh_.triangles[t][c]]) normal = apices(t) == 1 ? glm::dvec3(0.0) : facets_[t];
        out_.normals[t][c] = glm::vec3(normal);
      }
    }
  }

  int apices(std::uint32_t t) const {
    const auto& c = mesh_.triangles[t];
    return (apex_[c[0]] ? 1 : 0) + (apex_[c[1]] ? 1 : 0) + (apex_[c[2]] ? 1 : 0);
  }

  glm::dvec3 estimatedNormal(std::uint32_t r) {
    glm::dvec3 sum(0.0);
    for (const std::uint32_t corner : corners_[r]) sum += weighted(mesh_, corner / 3, corner % 3);
    const double length = glm::length(sum);
    if (!(length > 0.0)) return sum;
    if (apex_[mesh_.triangles[r / 3][r % 3]]) return sum / length;
    const QuadricFit fit = quadricAround(r, sum / length);
    fits_[r] = fit.fits;
    return fit.normal;
  }

  QuadricFit quadricAround(std::uint32_t r, const glm::dvec3& normal) {
    self_ = mesh_.triangles[r / 3][r % 3];
    around_.clear();
    points_.clear();
    addAround(r);
    const std::size_t ring = around_.size();
    for (std::size_t i = 0; i < ring; ++i) addAround(around_[i]);
    for (const std::uint32_t corner : around_) points_.push_back(place(corner / 3, corner % 3));
    return fitQuadric(place(r / 3, r % 3), normal, points_);
  }

  /// Appends the groups of the other corners of the triangles around a group.
  void addAround(std::uint32_t group) {
    for (const std::uint32_t corner : corners_[group])
      for (const std::uint32_t step : {1u, 2u}) {
        const std::uint32_t t = corner / 3, c = (corner % 3 + step) % 3;
        const std::uint32_t other = root_[3 * t + c];
        if (around_.size() >= kMaxAround) return;
        const bool known = std::find(around_.begin(), around_.end(), other) != around_.end();
        if (!known && mesh_.triangles[t][c] != self_) around_.push_back(other);
      }
  }

  void setRegions() {
    DisjointSets groups(count());
    for (std::uint32_t t = 0; t < count(); ++t)
      for (const std::uint32_t n : out_.smoothAcross[t])
        if (n != kNone) groups.join(t, n);
    out_.region.resize(count());
    for (std::uint32_t t = 0; t < count(); ++t) out_.region[t] = groups.find(t);
  }

  /// What a group of corners knows of the surface.
  struct Bend {
    double off = 0.0, turn = 0.0;  // sums over edges: out of symmetry; half the turn of the normals; squared
    double convex = 0.0, concave = 0.0;  // 1/m
  };

  void setBends() {
    std::vector<Bend> bends(root_.size());
    for (std::uint32_t t = 0; t < count(); ++t) {
      if (creaseAt(t) == 0.0) continue;
      for (std::uint32_t e = 0; e < 3; ++e) addEdge(t, e, bends);
      addCurvature(t, bends);
    }
    out_.bends.resize(count());
    const std::vector<double> trust = trustIn(bends);
    for (std::uint32_t t = 0; t < count(); ++t)
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t r = root_[3 * t + c];
        out_.bends[t][c] = {packCurvature(bends[r].convex), packCurvature(bends[r].concave),
                            static_cast<std::uint16_t>(65535.0 * trust[r])};
      }
  }

  /// CornerBend::trust of each group, from its own edges and those of the triangles around it.
  std::vector<double> trustIn(const std::vector<Bend>& bends) {
    std::vector<double> trust(root_.size(), 1.0), off(root_.size(), 0.0), turn(root_.size(), 0.0);
    for (std::uint32_t t = 0; t < count(); ++t) {
      double offHere = 0.0, turnHere = 0.0;
      for (std::uint32_t c = 0; c < 3; ++c) {
        offHere += bends[root_[3 * t + c]].off;
        turnHere += bends[root_[3 * t + c]].turn;
      }
      for (std::uint32_t c = 0; c < 3; ++c) {
        off[root_[3 * t + c]] += offHere;
        turn[root_[3 * t + c]] += turnHere;
      }
    }
    for (std::uint32_t r = 0; r < root_.size(); ++r) {
      if (corners_[r].empty() || creaseAt(r / 3) == 0.0) continue;
      const double noise = std::sqrt(off[r] / (turn[r] + kLeastNoise));
      if (noise <= kSurface) continue;
      if (noise < kNoise && onQuadric(r)) continue;
      trust[r] = 1.0 - glm::smoothstep(kSurface, kUnexplained, noise);
    }
    return trust;
  }

  bool onQuadric(std::uint32_t r) {
    const glm::dvec3 normal(out_.normals[r / 3][r % 3]);
    return creaseAt(r / 3) > 0.0 || normal == glm::dvec3(0.0) ? fits_[r] : quadricAround(r, normal).fits;
  }

  void addEdge(std::uint32_t t, std::uint32_t e, std::vector<Bend>& bends) const {
    const glm::dvec3 a(out_.normals[t][e]), b(out_.normals[t][(e + 1) % 3]);
    if (a == glm::dvec3(0.0) || b == glm::dvec3(0.0)) return;
    const glm::dvec3 edge = glm::normalize(place(t, e + 1) - place(t, e));
    const double off = 0.5 * glm::dot(edge, a + b), turn = 0.5 * glm::distance(a, b);
    for (const std::uint32_t c : {e, (e + 1) % 3}) {
      Bend& bend = bends[root_[3 * t + c]];
      bend.off += off * off;
      bend.turn += turn * turn;
    }
  }

  /// Raises the curvatures of a triangle's corners to the largest over its patch, and its height to `relief`.
  void addCurvature(std::uint32_t t, std::vector<Bend>& bends) {
    const CurvedPatch patch(mesh_, t, out_.normals[t], {1.0, 1.0, 1.0});
    double convex = 0.0, concave = 0.0;
    const double places[7][2] = {
        {1.0 / 3.0, 1.0 / 3.0}, {0.5, 0.0}, {0.0, 0.5}, {0.5, 0.5}, {0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
    for (std::size_t i = 0; i < 7; ++i) {
      const auto& [u, v] = places[i];
      if (i >= 4 && isApex(out_.normals[t][i - 4])) continue;
      glm::dvec3 p, pU, pV, n, nU, nV;
      patch.at(u, v, p, pU, pV);
      out_.relief = std::max(out_.relief, 1.5 * glm::distance(p, patch.facetAt(u, v)));
      patch.normalAt(u, v, n, nU, nV);
      // The map of steps on the patch to turns of the normal, in orthonormal axes x, y of the patch.
      const glm::dvec3 x = glm::normalize(pU), y = glm::normalize(pV - x * glm::dot(x, pV));
      const double uu = glm::length(pU), vx = glm::dot(pV, x), vy = glm::dot(pV, y);
      const glm::dvec3 alongX = nU / uu, alongY = (nV - alongX * vx) / vy;
      const double a = glm::dot(alongX, x), d = glm::dot(alongY, y), b = glm::dot(alongX, y),
                   c = glm::dot(alongY, x);
      const double mean = 0.5 * (a + d), spread = std::hypot(0.5 * (a - d), 0.5 * (b + c)),
                   twist = 0.5 * std::abs(b - c);
      if (!std::isfinite(mean + spread + twist)) continue;
      convex = std::max(convex, mean + spread + twist);
      concave = std::max(concave, spread - mean + twist);
    }
    for (std::uint32_t c = 0; c < 3; ++c) {
      Bend& bend = bends[root_[3 * t + c]];
      bend.convex = std::max(bend.convex, convex);
      bend.concave = std::max(bend.concave, concave);
    }
  }

  const Mesh& mesh_;
  std::span<const double> creaseOf_;
  ShadedMesh out_;
  std::vector<glm::dvec3> facets_;                    // T, unit
  std::vector<std::array<std::uint8_t, 3>> pending_;  // T, edges that need an apex at one end
  std::vector<bool> apex_;                            // of each vertex
  std::vector<std::uint32_t> root_;                   // 3T, the first corner of the group
  Buckets corners_;                                   // of the groups
  std::vector<bool> fits_;                            // of the groups: their vertices lie on a quadric
  std::uint32_t self_ = kNone;                        // the vertex that is being fitted,
  std::vector<std::uint32_t> around_;                 // groups around it,
  std::vector<glm::dvec3> points_;                    // and their places
};

}  // namespace

ShadedMesh shadeMesh(const Mesh& mesh, std::span<const double> creaseOf) {
  return MeshShader(mesh, creaseOf).shade();
}

}  // namespace tandem::haptics
