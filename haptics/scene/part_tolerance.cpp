#include "haptics/scene/part_tolerance.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <thread>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "assets/scene/control.h"
#include "assets/scene/part_pairs.h"
#include "haptics/base/in_parallel.h"
#include "haptics/geometry/mesh_distance.h"
#include "haptics/geometry/placed_bounds.h"
#include "haptics/geometry/scene_bvh.h"
#include "haptics/overlap/mesh_intrusion.h"
#include "haptics/overlap/mesh_overlap.h"
#include "haptics/scene/contact_scene_data.h"

namespace tandem::haptics {
namespace {

constexpr double kUsual = 0x1p-14;   // of the smallest held part's diagonal
constexpr double kFinest = 0x1p-17;  // of a part's own diagonal: the limit of its floats and budget
constexpr double kCoarsest = 0x1p-9;

struct Pair {
  PartId a, b;
  double reach;           // m, beyond which a clearance does not tighten the tolerance
  std::size_t triangles;  // of both parts: the cost
};

class Clearances {
 public:
  Clearances(const assets::Scene& scene, std::span<const Collider> colliders,
             std::vector<PartTolerance>& tolerances)
      : scene_(scene), colliders_(colliders), tolerances_(tolerances) {}

  void run(int threads) {
    findPairs();
    std::vector<double> found(pairs_.size(), 0.0);
    std::atomic<std::size_t> next{0};
    onThreads(std::max(1, threads), [&](int) {
      for (std::size_t i = next++; i < pairs_.size(); i = next++) found[i] = clearanceOf(pairs_[i]);
    });
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      note(pairs_[i].a, pairs_[i].b, found[i]);
      note(pairs_[i].b, pairs_[i].a, found[i]);
    }
  }

 private:
  /// A held control moves only along its axis, whatever stands in the way.
  bool canBeHeld(PartId part) const {
    return scene_.parts[part].movable && assets::controlOf(scene_, part) == nullptr;
  }
  /// Distance within which a neighbour can tighten the tolerance of a part, m; 0 if none can.
  double reachOf(PartId part) const {
    const PartTolerance& tolerance = tolerances_[part];
    return tolerance.from == PartTolerance::From::given ? 0.0 : tolerance.tolerance / kShareOfClearance;
  }
  PlacedMesh placed(PartId part) const { return {colliders_[part].tree, scene_.parts[part].worldFromPart}; }

  void findPairs() {
    std::vector<assets::Bounds> boxes(colliders_.size());
    std::vector<bool> holdable(colliders_.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (colliders_[i].tree != nullptr)
        boxes[i] = boundsAt(colliders_[i].tree->bounds(), scene_.parts[i].worldFromPart);
      holdable[i] = canBeHeld(static_cast<PartId>(i));
    }
    const SceneBvh tree(boxes);
    for (PartId a = 0; a < boxes.size(); ++a) {
      if (!holdable[a] || colliders_[a].tree == nullptr) continue;
      // The largest reach of all parts, because a neighbour's reach may exceed the part's own.
      const assets::Bounds near{boxes[a].min - largestReach(), boxes[a].max + largestReach()};
      tree.forEach(near, [&](PartId b) {
        if (b == a || (holdable[b] && b < a)) return;
        addPair(std::min(a, b), std::max(a, b), boxes);
      });
    }
    std::sort(pairs_.begin(), pairs_.end(), [](const Pair& l, const Pair& r) {
      if (l.triangles != r.triangles) return l.triangles > r.triangles;
      return l.a != r.a ? l.a < r.a : l.b < r.b;
    });
  }

  double largestReach() {
    if (largestReach_ < 0.0)
      for (PartId part = 0; part < colliders_.size(); ++part)
        largestReach_ = std::max(largestReach_, reachOf(part));
    return largestReach_;
  }

  void addPair(PartId a, PartId b, const std::vector<assets::Bounds>& boxes) {
    const double reach = std::max(reachOf(a), reachOf(b));
    const glm::dvec3 separation =
        glm::max(glm::max(boxes[a].min - boxes[b].max, boxes[b].min - boxes[a].max), glm::dvec3(0.0));
    if (!(reach > 0.0) || glm::length(separation) > reach || !assets::mayCollide(scene_, a, b)) return;
    pairs_.push_back(
        {a, b, reach,
         colliders_[a].tree->mesh().triangles.size() + colliders_[b].tree->mesh().triangles.size()});
  }

  /// Clearance, m; 0 if none matters.
  double clearanceOf(const Pair& pair) const {
    const PlacedMesh a = placed(pair.a), b = placed(pair.b);
    MeshGap gap;
    if (!nearestPoints(a, b, pair.reach, gap)) return 0.0;
    const double resolvable = kFinest * 2.0 * std::max(colliders_[pair.a].radius, colliders_[pair.b].radius);
    if (gap.distance <= std::max(resolvable, touchTolerance(a, b))) return 0.0;
    // Where surfaces are nearest, one part may be inside the other.
    const bool overlap = containsPoint(*b.tree, transformPoint(inverse(b.worldFromMesh), gap.onA)) ||
                         containsPoint(*a.tree, transformPoint(inverse(a.worldFromMesh), gap.onB));
    return overlap ? 0.0 : gap.distance;
  }

  void note(PartId part, PartId neighbour, double clearance) {
    PartTolerance& own = tolerances_[part];
    if (clearance <= 0.0 || own.from == PartTolerance::From::given) return;
    const bool nearer = own.neighbour == kNoPart || clearance < own.clearance ||
                        (clearance == own.clearance && neighbour < own.neighbour);
    if (!nearer) return;
    own.clearance = clearance;
    own.neighbour = neighbour;
  }

  const assets::Scene& scene_;
  std::span<const Collider> colliders_;
  std::vector<PartTolerance>& tolerances_;
  std::vector<Pair> pairs_;
  double largestReach_ = -1.0;
};

}  // namespace

double usualTolerance(double smallestHeld, double diagonal) {
  // A part far larger than the held part is limited by its own size.
  return std::clamp(kUsual * smallestHeld, kFinest * diagonal, kUsual * diagonal);
}

double usableTolerance(double tolerance, double diagonal) {
  return std::clamp(tolerance, kFinest * diagonal, kCoarsest * diagonal);
}

std::vector<PartTolerance> tolerancesWithoutClearance(const assets::Scene& scene,
                                                      std::span<const Collider> colliders,
                                                      double smallestHeld) {
  std::vector<PartTolerance> tolerances(colliders.size());
  for (std::size_t i = 0; i < tolerances.size(); ++i) {
    const double diagonal = 2.0 * colliders[i].radius, given = scene.parts[i].contactTolerance;
    if (colliders[i].tree == nullptr) continue;
    tolerances[i].tolerance = given > 0.0 ? given : usualTolerance(smallestHeld, diagonal);
    if (given > 0.0) tolerances[i].from = PartTolerance::From::given;
  }
  return tolerances;
}

std::vector<PartTolerance> partTolerances(const assets::Scene& scene, std::span<const Collider> colliders,
                                          double smallestHeld, int threads) {
  std::vector<PartTolerance> tolerances = tolerancesWithoutClearance(scene, colliders, smallestHeld);
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Clearances(scene, colliders, tolerances).run(threads > 0 ? threads : cores);
  for (std::size_t i = 0; i < tolerances.size(); ++i) {
    PartTolerance& own = tolerances[i];
    const double wanted = std::max(kShareOfClearance * own.clearance, kFinest * 2.0 * colliders[i].radius);
    if (own.neighbour == kNoPart || wanted >= own.tolerance) continue;
    own.from = PartTolerance::From::clearance;
    own.tolerance = wanted;
  }
  return tolerances;
}

}  // namespace tandem::haptics
