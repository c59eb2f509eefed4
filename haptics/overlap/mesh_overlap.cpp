#include "haptics/overlap/mesh_overlap.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "assets/base/assert.h"
#include "haptics/geometry/bvh_pairs.h"
#include "haptics/geometry/triangle_pair.h"
#include "haptics/overlap/mesh_intrusion.h"

namespace tandem::haptics {
namespace {

/// Of the smaller part's size: by how much a depth may be too small.
constexpr double kPrecision = 0x1p-23;
/// Of the larger part's size: a depth that lids change by less is known.
constexpr double kKnown = 0x1p-20;
/// Of the larger part's size: triangles that stand through each other by less cross by rounding alone.
constexpr double kCrosses = 0x1p-42;
constexpr double kFarthest = std::numeric_limits<double>::max();

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

double diagonalOf(const TriangleBvh& tree) { return glm::length(tree.bounds().max - tree.bounds().min); }

/// A pair of meshes, in A's frame where it is not said otherwise.
class Overlapping {
 public:
  Overlapping(const PlacedMesh& a, const MeshClosing& closedA, const PlacedMesh& b,
              const MeshClosing& closedB)
      : a_(a),
        b_(b),
        closedA_(closedA),
        closedB_(closedB),
        aFromB_(inverse(a.worldFromMesh) * b.worldFromMesh),
        bFromA_(inverse(aFromB_)),
        tolerance_(touchTolerance(a, b)),
        known_(kKnown * std::max(closedA.size(), closedB.size())) {}

  MeshOverlap measure() {
    if (isSame()) {
      for (std::uint32_t i = 0; i < a_.tree->mesh().triangles.size(); ++i) pairs_.push_back({i, i, 0.0});
      measureCoincidence();
      overlap_.meeting = overlap_.depth > tolerance_ || overlap_.open ? Meeting::crossing : Meeting::touching;
      return overlap_;
    }
    pairs_ = nearPairs(*a_.tree, *b_.tree, aFromB_, tolerance_);
    const bool cross = std::any_of(pairs_.begin(), pairs_.end(),
                                   [&](const NearPair& pair) { return pair.through > tolerance_; });
    measureDepth(cross);
    if (overlap_.depth <= tolerance_ && !overlap_.open) measureCoincidence();
    if (overlap_.depth <= tolerance_ && cross && !overlap_.open) measureSheets();
    if (overlap_.depth > tolerance_)
      overlap_.meeting = pairs_.empty() ? Meeting::contained : Meeting::crossing;
    else if (overlap_.open)
      overlap_.meeting = Meeting::crossing;
    else if (!pairs_.empty())
      overlap_.meeting = Meeting::touching;
    return overlap_;
  }

 private:
  double precision() const { return kPrecision * std::min(diagonalOf(*a_.tree), diagonalOf(*b_.tree)); }

  /// One mesh in the other, with the pairs that are near: of surfaces, and of the one with the other's lids.
  Intrusion intrusion(bool ofA) const {
    const TriangleBvh& mesh = ofA ? *a_.tree : *b_.tree;
    const MeshClosing& solid = ofA ? closedB_ : closedA_;
    Intrusion in{mesh, solid, ofA ? bFromA_ : aFromB_, {}, tolerance_, precision()};
    const double rounding = kCrosses * std::max(closedA_.size(), closedB_.size());
    for (const NearPair& pair : pairs_)
      in.near.push_back({ofA ? pair.a : pair.b, ofA ? pair.b : pair.a, false, pair.through > rounding});
    if (solid.lids() == nullptr) return in;
    for (const NearPair& pair : nearPairs(mesh, *solid.lids(), inverse(in.solidFromMesh), tolerance_))
      in.near.push_back({pair.a, pair.b, true, pair.through > rounding});
    return in;
  }

  void measureDepth(bool cross) {
    const Intrusion ofA = intrusion(true), ofB = intrusion(false);
    // The solid without lids first: what is found in it spares much of the search in the other.
    const bool firstInA = closedA_.lids() == nullptr && closedB_.lids() != nullptr;
    Deepest first, second;
    const bool lidsFirst = findDeepest(firstInA ? ofB : ofA, first);
    second.depth = first.depth;  // only a deeper point matters
    const bool lidsSecond = findDeepest(firstInA ? ofA : ofB, second);
    const Deepest& deepest = second.found ? second : first;
    overlap_.inA = deepest.found && second.found != firstInA;
    const Pose& world = overlap_.inA ? a_.worldFromMesh : b_.worldFromMesh;
    if (deepest.found) {
      overlap_.depth = deepest.depth;
      overlap_.deepest = transformPoint(world, deepest.point);
      overlap_.exitPath = transformVector(world, deepest.exitPath);
    }
    if (overlap_.depth <= tolerance_ && !cross) return;  // a thing before a hole is in nothing for certain
    const double known = overlap_.depth + known_;
    overlap_.open = (lidsFirst && anyDeeperWithoutLids(firstInA ? ofB : ofA, known)) ||
                    (lidsSecond && anyDeeperWithoutLids(firstInA ? ofA : ofB, known));
    if (overlap_.depth <= tolerance_ && overlap_.open) witnessCrossing();
  }

  /// Where the surfaces cross: the place of the pair that stands through each other furthest.
  void witnessCrossing() {
    const auto furthest =
        std::max_element(pairs_.begin(), pairs_.end(),
                         [](const NearPair& l, const NearPair& r) { return l.through < r.through; });
    ASSERT(furthest != pairs_.end());
    const TrianglePairGap gap =
        nearestPoints(a_.tree->triangle(furthest->a), transformed(aFromB_, b_.tree->triangle(furthest->b)));
    overlap_.depth = 0.0;
    overlap_.deepest = transformPoint(a_.worldFromMesh, gap.onA);
    overlap_.exitPath = glm::dvec3(0.0);
  }

  /// Whether one side of a triangle is certainly inside a solid, that is, whether points close to its centre
  /// differ.
  bool boundsSolid(const MeshClosing& closed, std::uint32_t triangle) const {
    const Triangle t = closed.tree().triangle(triangle);
    const glm::dvec3 normal = areaVector(t), middle = (t.a + t.b + t.c) / 3.0;
    const double length = glm::length(normal);
    if (!(length > 0.0)) return true;  // no information; its neighbours decide
    const glm::dvec3 step = normal * (4.0 * tolerance_ / length);
    return isIn(closed, middle + step) != isIn(closed, middle - step);
  }
  static bool isIn(const MeshClosing& closed, const glm::dvec3& p) {
    return closed.contains(p) && closed.isCertain(p);
  }

  /// For surfaces without an inside: the greatest length by which a facet stands through another.
  void measureSheets() {
    for (const NearPair& pair : pairs_) {
      if (pair.through <= std::max(tolerance_, overlap_.depth)) continue;
      const Triangle t = a_.tree->triangle(pair.a), other = transformed(aFromB_, b_.tree->triangle(pair.b));
      const TrianglePairGap gap = nearestPoints(t, other);
      if (gap.square > 0.0) continue;
      if (boundsSolid(closedA_, pair.a) || boundsSolid(closedB_, pair.b)) continue;
      overlap_.depth = pair.through;
      overlap_.deepest = transformPoint(a_.worldFromMesh, gap.onA);
      overlap_.exitPath = glm::dvec3(0.0);
      overlap_.sheets = overlap_.open = true;
    }
  }

  /// The triangles of A at which to look for coinciding surfaces: touched ones, evenly through the mesh.
  std::vector<std::uint32_t> someTouched() const {
    constexpr std::size_t kMaxTriangles = 256;
    const std::size_t count = a_.tree->mesh().triangles.size(),
                      step = std::max<std::size_t>(1, count / kMaxTriangles);
    std::vector<std::uint32_t> touched;
    for (const NearPair& pair : pairs_)
      if (pair.a % step == 0) touched.push_back(pair.a);
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    return touched;
  }

  /// The point of either surface that is nearest to a given one; both in A's frame.
  struct Nearest {
    MeshPoint at;
    bool isOfA = true;
  };
  Nearest nearest(const glm::dvec3& p) const {
    Nearest found;
    MeshPoint ofB;
    a_.tree->closestPoint(p, kFarthest, found.at);
    if (!b_.tree->closestPoint(transformPoint(bFromA_, p), found.at.distance, ofB)) return found;
    if (!(ofB.distance < found.at.distance)) return found;
    ofB.point = transformPoint(aFromB_, ofB.point);
    return {ofB, false};
  }
  /// The same of both surfaces and their lids, but those of slits.
  MeshPoint nearestWithLids(const glm::dvec3& p) const {
    MeshPoint best = nearest(p).at, lid;
    double reach = std::max(0.0, best.distance - kSlit * tolerance_);
    if (closedA_.lids() != nullptr && closedA_.lids()->closestPoint(p, reach, lid)) {
      best = lid;
      reach = lid.distance;
    }
    if (closedB_.lids() != nullptr && closedB_.lids()->closestPoint(transformPoint(bFromA_, p), reach, lid)) {
      best = lid;
      best.point = transformPoint(aFromB_, lid.point);
    }
    return best;
  }
  bool hasLids() const { return closedA_.lids() != nullptr || closedB_.lids() != nullptr; }

  /// See overlapOf().
  void measureCoincidence() {
    double withoutLids = 0.0;  // m, depth of the centre of the largest ball when lids do not count
    for (const std::uint32_t index : someTouched()) {
      const Facet facet = facetOf(a_.tree->triangle(index));
      const glm::dvec3 middle = (facet.t.a + facet.t.b + facet.t.c) / 3.0;
      for (const double side : {-1.0, 1.0}) {
        const glm::dvec3 inwards = facet.normal * side, start = middle + inwards * (4.0 * tolerance_);
        if (!isIn(closedA_, start) || !isIn(closedB_, transformPoint(bFromA_, start))) continue;
        const double radius = ballRadius(middle, inwards, hasLids());
        keepBall(middle + inwards * radius);
        if (!hasLids()) continue;
        const double wider = radiusWithoutLids(middle, inwards, radius);
        withoutLids = std::max(withoutLids, nearest(middle + inwards * wider).at.distance);
      }
    }
    overlap_.open = withoutLids > std::max(overlap_.depth, 4.0 * tolerance_) + known_;
    if (overlap_.depth <= tolerance_ && overlap_.open) witnessCrossing();
  }

  /// Shrinks a ball that touches a facet's centre until no surface is in it (Ma, Bae & Choi 2012, "3D
  /// medial axis point approximation using nearest neighbors and the normal field"). Surfaces within the
  /// tolerance of the facet's plane, beside its centre, are the facet itself and the one that coincides
  /// with it.
  double ballRadius(const glm::dvec3& middle, const glm::dvec3& inwards, bool countLids) const {
    constexpr int kMaxSteps = 64;
    double radius = 0.0;
    for (const glm::dvec3& p : a_.tree->mesh().positions) radius = std::max(radius, glm::length(p - middle));
    for (int i = 0; i < kMaxSteps; ++i) {
      const glm::dvec3 centre = middle + inwards * radius;
      const MeshPoint at = countLids ? nearestWithLids(centre) : nearest(centre).at;
      const glm::dvec3 path = at.point - middle;
      const double into = radius - at.distance, square = glm::dot(path, path);
      if (into <= precision() || (into <= 2.0 * tolerance_ && square <= 8.0 * radius * tolerance_)) break;
      radius = square / (2.0 * glm::dot(path, inwards));
    }
    return radius;
  }

  /// The radius of the ball that only surfaces bound, its centre inside meshes and lids as that of the ball
  /// of `least` is.
  double radiusWithoutLids(const glm::dvec3& middle, const glm::dvec3& inwards, double least) const {
    constexpr int kHalvings = 16;
    const auto holds = [&](double radius) {
      const glm::dvec3 centre = middle + inwards * radius;
      return closedA_.contains(centre) && closedB_.contains(transformPoint(bFromA_, centre));
    };
    double most = ballRadius(middle, inwards, false);
    if (holds(most)) return most;
    for (int i = 0; i < kHalvings; ++i) {
      const double between = 0.5 * (least + most);
      (holds(between) ? least : most) = between;
    }
    return least;
  }

  /// Keeps the ball about `centre`, which reaches to the nearest surface, if it is the largest that is inside
  /// for certain.
  void keepBall(const glm::dvec3& centre) {
    const Nearest found = nearest(centre);
    if (found.at.distance <= std::max(4.0 * tolerance_, overlap_.depth)) return;
    if (hasLids() && (!isIn(closedA_, centre) || !isIn(closedB_, transformPoint(bFromA_, centre)))) return;
    overlap_.depth = found.at.distance;
    overlap_.deepest = transformPoint(a_.worldFromMesh, centre);
    overlap_.exitPath = transformVector(a_.worldFromMesh, found.at.point - centre);
    overlap_.inA = found.isOfA;
  }

  /// Whether both are the same mesh at the same place.
  bool isSame() const {
    if (a_.tree != b_.tree) return false;
    const assets::Bounds& box = a_.tree->bounds();
    const double farthest = glm::length(glm::max(glm::abs(box.min), glm::abs(box.max)));
    const double angle = glm::length(rotationVector(aFromB_.orientation));
    return glm::length(aFromB_.position) + angle * farthest <= 0.5 * tolerance_;
  }

  const PlacedMesh &a_, &b_;
  const MeshClosing &closedA_, &closedB_;
  Pose aFromB_, bFromA_;
  double tolerance_, known_;  // m
  std::vector<NearPair> pairs_;
  MeshOverlap overlap_;
};

}  // namespace

double touchTolerance(const PlacedMesh& a, const PlacedMesh& b) {
  const auto farthest = [](const TriangleBvh& tree) {
    return glm::length(glm::max(glm::abs(tree.bounds().min), glm::abs(tree.bounds().max)));
  };
  const double places = glm::length(a.worldFromMesh.position) + glm::length(b.worldFromMesh.position);
  return 0x1p-20 * std::max(diagonalOf(*a.tree), diagonalOf(*b.tree)) +
         0x1p-22 * std::max(farthest(*a.tree), farthest(*b.tree)) + 0x1p-48 * places;
}

MeshOverlap overlapOf(const PlacedMesh& a, const MeshClosing& closedA, const PlacedMesh& b,
                      const MeshClosing& closedB) {
  ASSERT(a.tree != nullptr && b.tree != nullptr);
  ASSERT(&closedA.tree() == a.tree && &closedB.tree() == b.tree);
  if (a.tree->empty() || b.tree->empty()) return {};
  return Overlapping(a, closedA, b, closedB).measure();
}

MeshOverlap overlapOf(const PlacedMesh& a, const PlacedMesh& b) {
  ASSERT(a.tree != nullptr && b.tree != nullptr);
  const MeshClosing closedA(*a.tree);
  if (a.tree == b.tree) return overlapOf(a, closedA, b, closedA);
  return overlapOf(a, closedA, b, MeshClosing(*b.tree));
}

}  // namespace tandem::haptics
