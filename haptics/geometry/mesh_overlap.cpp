#include "haptics/geometry/mesh_overlap.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "assets/base/assert.h"
#include "haptics/geometry/bvh_pairs.h"
#include "haptics/geometry/mesh_intrusion.h"
#include "haptics/geometry/triangle_pair.h"

namespace tandem::haptics {
namespace {

struct NearPair {
  std::uint32_t a, b;
  double through;  // m: standThrough() of the two
};

Triangle transformed(const Pose& pose, const Triangle& t) {
  return {transformPoint(pose, t.a), transformPoint(pose, t.b), transformPoint(pose, t.c)};
}

/// All pairs of triangles within `tolerance` of each other.
std::vector<NearPair> nearPairs(const TriangleBvh& a, const TriangleBvh& b, const Pose& aFromB,
                                double tolerance) {
  std::vector<NearPair> pairs;
  BvhPairs(a, b, aFromB)
      .forEach(tolerance,
               [&](std::uint32_t firstA, std::uint32_t countA, std::uint32_t firstB, std::uint32_t countB) {
                 Facet facets[TriangleBvh::kMaxLeaf];
                 for (std::uint32_t i = 0; i < countA; ++i) {
                   facets[i] = facetOf(a.triangle(a.leafTriangle(firstA + i)));
                 }
                 for (std::uint32_t j = 0; j < countB; ++j) {
                   const std::uint32_t indexB = b.leafTriangle(firstB + j);
                   const Facet other = facetOf(transformed(aFromB, b.triangle(indexB)));
                   for (std::uint32_t i = 0; i < countA; ++i) {
                     if (furtherThan(tolerance, facets[i], other)) continue;
                     if (!comeNear(facets[i].t, other.t, tolerance)) continue;
                     pairs.push_back({a.leafTriangle(firstA + i), indexB, standThrough(facets[i], other)});
                   }
                 }
               });
  return pairs;
}

/// Adds the crossings of the edges of triangle `t` of `mesh` with `other`, which is in the mesh's frame.
void addCuts(const TriangleBvh& mesh, std::uint32_t t, const Triangle& other, std::vector<EdgeCut>& cuts) {
  const auto& corners = mesh.mesh().triangles[t];
  for (std::size_t e = 0; e < 3; ++e) {
    const std::uint32_t from = std::min(corners[e], corners[(e + 1) % 3]),
                        to = std::max(corners[e], corners[(e + 1) % 3]);
    const double share = pierceShare(mesh.mesh().positions[from], mesh.mesh().positions[to], other);
    if (share >= 0.0) cuts.push_back({from, to, share});
  }
}

/// The deepest point of one mesh in the other.
Deepest intrusion(const TriangleBvh& mesh, const TriangleBvh& solid, const Pose& solidFromMesh,
                  const std::vector<NearPair>& pairs, std::uint32_t NearPair::*own,
                  std::uint32_t NearPair::*others, double tolerance, bool cross) {
  const Pose meshFromSolid = inverse(solidFromMesh);
  std::vector<std::uint32_t> touched;
  std::vector<EdgeCut> cuts;
  for (const NearPair& pair : pairs) {
    touched.push_back(pair.*own);
    addCuts(mesh, pair.*own, transformed(meshFromSolid, solid.triangle(pair.*others)), cuts);
  }
  return deepestInside(mesh, solid, solidFromMesh, touched, std::move(cuts), tolerance, cross);
}

/// Whether one side of a triangle is inside a solid, that is, whether points close to its centre differ.
bool boundsSolid(const TriangleBvh& tree, std::uint32_t triangle, double tolerance) {
  const Triangle t = tree.triangle(triangle);
  const glm::dvec3 normal = areaVector(t), middle = (t.a + t.b + t.c) / 3.0;
  const double length = glm::length(normal);
  if (!(length > 0.0)) return true;  // no information; its neighbours decide
  const glm::dvec3 step = normal * (4.0 * tolerance / length);
  return containsPoint(tree, middle + step) != containsPoint(tree, middle - step);
}

/// For surfaces without an inside: the greatest length by which a facet stands through another.
void measureSheets(const PlacedMesh& a, const PlacedMesh& b, const Pose& aFromB,
                   const std::vector<NearPair>& pairs, double tolerance, MeshOverlap& overlap) {
  for (const NearPair& pair : pairs) {
    if (pair.through <= std::max(tolerance, overlap.depth)) continue;
    const Triangle t = a.tree->triangle(pair.a), other = transformed(aFromB, b.tree->triangle(pair.b));
    const TrianglePairGap gap = nearestPoints(t, other);
    if (gap.square > 0.0) continue;
    if (boundsSolid(*a.tree, pair.a, tolerance) || boundsSolid(*b.tree, pair.b, tolerance)) continue;
    overlap.depth = pair.through;
    overlap.deepest = transformPoint(a.worldFromMesh, gap.onA);
    overlap.exitPath = glm::dvec3(0.0);
    overlap.sheets = true;
  }
}

/// The largest touched triangles of A.
std::vector<std::uint32_t> largestTouched(const TriangleBvh& a, const std::vector<NearPair>& pairs,
                                          std::size_t maxCount) {
  std::vector<std::uint32_t> touched;
  for (const NearPair& pair : pairs) touched.push_back(pair.a);
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  const auto area = [&](std::uint32_t t) { return glm::length(areaVector(a.triangle(t))); };
  maxCount = std::min(maxCount, touched.size());
  std::partial_sort(
      touched.begin(), touched.begin() + static_cast<std::ptrdiff_t>(maxCount), touched.end(),
      [&](std::uint32_t l, std::uint32_t r) { return area(l) != area(r) ? area(l) > area(r) : l < r; });
  touched.resize(maxCount);
  return touched;
}

/// For surfaces that coincide with both insides on the same side, such as a duplicated part, where no point
/// of one is inside the other. Walks inwards from the centres of some facets in doubling steps.
void measureCoincidence(const PlacedMesh& a, const PlacedMesh& b, const Pose& aFromB,
                        const std::vector<NearPair>& pairs, double tolerance, MeshOverlap& overlap) {
  constexpr std::size_t kFacets = 8;
  const Pose bFromA = inverse(aFromB);
  for (const std::uint32_t index : largestTouched(*a.tree, pairs, kFacets)) {
    const Facet facet = facetOf(a.tree->triangle(index));
    const glm::dvec3 middle = (facet.t.a + facet.t.b + facet.t.c) / 3.0;
    for (const double side : {-1.0, 1.0}) {
      for (double step = 4.0 * tolerance;; step *= 2.0) {
        const glm::dvec3 p = middle + facet.normal * (side * step);
        MeshPoint onA, onB;
        if (!containsPoint(*a.tree, p) || !containsPoint(*b.tree, transformPoint(bFromA, p))) break;
        const double everywhere = std::numeric_limits<double>::max();
        if (!a.tree->closestPoint(p, everywhere, onA) ||
            !b.tree->closestPoint(transformPoint(bFromA, p), everywhere, onB)) {
          break;
        }
        const double depth = std::min(onA.distance, onB.distance);
        if (depth <= std::max(2.0 * tolerance, overlap.depth)) continue;
        overlap.depth = depth;
        overlap.deepest = transformPoint(a.worldFromMesh, p);
        const glm::dvec3 out = onA.distance <= onB.distance ? onA.point : transformPoint(aFromB, onB.point);
        overlap.exitPath = transformVector(a.worldFromMesh, out - p);
        overlap.inA = onA.distance <= onB.distance;
      }
    }
  }
}

double farthest(const assets::Bounds& box) {
  return glm::length(glm::max(glm::abs(box.min), glm::abs(box.max)));
}

/// Whether both are the same mesh at the same place.
bool isSame(const PlacedMesh& a, const PlacedMesh& b, const Pose& aFromB, double tolerance) {
  if (a.tree != b.tree) return false;
  const double angle = glm::length(rotationVector(aFromB.orientation));
  return glm::length(aFromB.position) + angle * farthest(a.tree->bounds()) <= 0.5 * tolerance;
}

}  // namespace

double touchTolerance(const PlacedMesh& a, const PlacedMesh& b) {
  const assets::Bounds &boxA = a.tree->bounds(), &boxB = b.tree->bounds();
  const double diagonal = std::max(glm::length(boxA.max - boxA.min), glm::length(boxB.max - boxB.min));
  const double places = glm::length(a.worldFromMesh.position) + glm::length(b.worldFromMesh.position);
  return 0x1p-20 * diagonal + 0x1p-22 * std::max(farthest(boxA), farthest(boxB)) + 0x1p-48 * places;
}

MeshOverlap overlapOf(const PlacedMesh& a, const PlacedMesh& b) {
  ASSERT(a.tree != nullptr && b.tree != nullptr);
  MeshOverlap overlap;
  if (a.tree->empty() || b.tree->empty()) return overlap;
  const double tolerance = touchTolerance(a, b);
  const Pose aFromB = inverse(a.worldFromMesh) * b.worldFromMesh, bFromA = inverse(aFromB);
  if (isSame(a, b, aFromB, tolerance)) {
    std::vector<NearPair> all;
    for (std::uint32_t i = 0; i < a.tree->mesh().triangles.size(); ++i) all.push_back({i, i, 0.0});
    measureCoincidence(a, b, aFromB, all, tolerance, overlap);
    overlap.meeting = overlap.depth > tolerance ? Meeting::crossing : Meeting::touching;
    return overlap;
  }
  const std::vector<NearPair> pairs = nearPairs(*a.tree, *b.tree, aFromB, tolerance);
  const bool cross =
      std::any_of(pairs.begin(), pairs.end(), [&](const NearPair& pair) { return pair.through > tolerance; });
  const Deepest ofA =
      intrusion(*a.tree, *b.tree, bFromA, pairs, &NearPair::a, &NearPair::b, tolerance, cross);
  const Deepest ofB =
      intrusion(*b.tree, *a.tree, aFromB, pairs, &NearPair::b, &NearPair::a, tolerance, cross);
  overlap.inA = ofB.depth > ofA.depth;
  const Deepest& deepest = overlap.inA ? ofB : ofA;
  if (deepest.found) {
    const Pose& world = overlap.inA ? a.worldFromMesh : b.worldFromMesh;
    overlap.depth = deepest.depth;
    overlap.deepest = transformPoint(world, deepest.point);
    overlap.exitPath = transformVector(world, deepest.exitPath);
  }
  if (overlap.depth <= tolerance && cross) measureSheets(a, b, aFromB, pairs, tolerance, overlap);
  if (overlap.depth <= tolerance) measureCoincidence(a, b, aFromB, pairs, tolerance, overlap);
  if (overlap.depth > tolerance) {
    overlap.meeting = pairs.empty() ? Meeting::contained : Meeting::crossing;
  } else if (!pairs.empty()) {
    overlap.meeting = Meeting::touching;
  }
  return overlap;
}

}  // namespace tandem::haptics
