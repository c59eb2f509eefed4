#include "client/review/clash_check.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include <glm/common.hpp>

#include "assets/base/assert.h"
#include "assets/mesh/equal_fits.h"
#include "assets/scene/part_pairs.h"
#include "client/review/facet_sag.h"
#include "haptics/base/in_parallel.h"
#include "haptics/geometry/placed_bounds.h"
#include "haptics/overlap/mesh_overlap.h"
#include "haptics/scene/contact_scene_data.h"

namespace tandem::client {

namespace {

using haptics::Meeting;
using haptics::PlacedMesh;
using haptics::TriangleBvh;

/// A part and the box around it, world frame.
struct BoxedPart {
  PartId part = kNoPart;
  assets::Bounds box;
};

struct Pair {
  PartId a, b;
  std::size_t triangles;  // of both, a measure of the cost
};

const TriangleBvh* treeOf(const haptics::ContactScene& contact, PartId part) {
  ASSERT(part < contact.data().colliders.size());
  const TriangleBvh* tree = contact.data().colliders[part].tree;
  return tree == nullptr || tree->empty() ? nullptr : tree;
}

/// The poses of all parts, given or the file's.
class Poses {
 public:
  Poses(const haptics::ContactScene& contact, std::span<const Pose> given)
      : scene_(contact.scene()), given_(given) {
    ASSERT(given.empty() || given.size() == scene_.parts.size());
  }
  const Pose& operator[](PartId part) const {
    return given_.empty() ? scene_.parts[part].worldFromPart : given_[part];
  }

 private:
  const assets::Scene& scene_;
  std::span<const Pose> given_;
};

/// Parts with geometry, sorted by the lower end of their boxes along x.
std::vector<BoxedPart> boxedParts(const haptics::ContactScene& contact, const Poses& worldFromPart) {
  std::vector<BoxedPart> parts;
  for (std::size_t i = 0; i < contact.scene().parts.size(); ++i) {
    const auto part = static_cast<PartId>(i);
    const TriangleBvh* tree = treeOf(contact, part);
    if (tree == nullptr) continue;
    BoxedPart boxed{part, {}};
    for (const glm::dvec3& p : tree->mesh().positions) {
      const glm::dvec3 world = transformPoint(worldFromPart[part], p);
      boxed.box.include(world);
    }
    parts.push_back(boxed);
  }
  std::sort(parts.begin(), parts.end(), [](const BoxedPart& l, const BoxedPart& r) {
    return l.box.min.x != r.box.min.x ? l.box.min.x < r.box.min.x : l.part < r.part;
  });
  return parts;
}

bool nearEnough(const assets::Bounds& a, const assets::Bounds& b, double reach) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.min[axis] > b.max[axis] + reach || b.min[axis] > a.max[axis] + reach) return false;
  }
  return true;
}

/// Pairs whose boxes come as near as the clearance, the most expensive first.
std::vector<Pair> nearPairs(const haptics::ContactScene& contact, const Poses& worldFromPart,
                            double clearance) {
  const std::vector<BoxedPart> parts = boxedParts(contact, worldFromPart);
  double largest = 0.0;  // m; boxes are grown by a bound of the pairs' own tolerances
  for (const BoxedPart& p : parts) {
    largest = std::max(
        {largest, glm::length(p.box.max - p.box.min), glm::length(p.box.max), glm::length(p.box.min)});
  }
  const double reach = clearance + 0x1p-18 * largest;
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = i + 1; j < parts.size() && parts[j].box.min.x <= parts[i].box.max.x + reach; ++j) {
      if (!nearEnough(parts[i].box, parts[j].box, reach)) continue;
      const PartId a = std::min(parts[i].part, parts[j].part), b = std::max(parts[i].part, parts[j].part);
      pairs.push_back(
          {a, b, treeOf(contact, a)->mesh().triangles.size() + treeOf(contact, b)->mesh().triangles.size()});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& l, const Pair& r) {
    if (l.triangles != r.triangles) return l.triangles > r.triangles;
    return l.a != r.a ? l.a < r.a : l.b < r.b;
  });
  return pairs;
}

double gapOf(const assets::Bounds& a, const assets::Bounds& b) {
  return glm::length(glm::max(glm::max(a.min - b.max, b.min - a.max), glm::dvec3(0.0)));
}

/// A part where it stands, and what its mesh lacks to be closed.
struct Standing {
  PlacedMesh mesh;
  const haptics::MeshClosing& closing;
};

Standing standing(const PartClosings& closings, PartId part, const Pose& worldFromPart) {
  return {{treeOf(closings.contact(), part), worldFromPart}, closings.of(part)};
}

/// Whether a point of one surface is certainly inside the other mesh.
bool oneHolds(const Standing& outer, const Standing& inner) {
  const glm::dvec3 p = transformPoint(inner.mesh.worldFromMesh, inner.mesh.tree->triangle(0).a);
  const glm::dvec3 local = transformPoint(inverse(outer.mesh.worldFromMesh), p);
  return outer.closing.contains(local) && outer.closing.isCertain(local);
}

void setWitness(const haptics::MeshOverlap& overlap, Clash& clash) {
  clash.kind = ClashKind::hard;
  clash.depth = overlap.depth;
  clash.contained = overlap.meeting == Meeting::contained;
  clash.open = overlap.open;
  clash.sheets = overlap.sheets;
  clash.onA = clash.onB = clash.deepest = overlap.deepest;
  (overlap.inA ? clash.onA : clash.onB) += overlap.exitPath;
}

/// The sag of the facets of both meshes at the witness points.
double sagOf(const PlacedMesh& a, const PlacedMesh& b, const Clash& clash) {
  double sag = 0.0;
  for (const auto& [mesh, point] : {std::pair{a, clash.onA}, std::pair{b, clash.onB}}) {
    haptics::MeshPoint nearest;
    const glm::dvec3 local = transformPoint(inverse(mesh.worldFromMesh), point);
    if (mesh.tree->closestPoint(local, std::numeric_limits<double>::max(), nearest))
      sag += facetSag(mesh.tree->mesh(), nearest.triangle);
  }
  return sag;
}

/// Nothing where the parts are further apart than `clearance`.
std::optional<Clash> measure(const Standing& first, const Standing& second, double clearance) {
  const PlacedMesh &a = first.mesh, &b = second.mesh;
  Clash clash;
  const haptics::MeshOverlap overlap = haptics::overlapOf(a, first.closing, b, second.closing);
  if (overlap.meeting == Meeting::crossing || overlap.meeting == Meeting::contained) {
    setWitness(overlap, clash);
    clash.facetSag = sagOf(a, b, clash);
    return clash;
  }
  const bool touches = overlap.meeting == Meeting::touching;
  haptics::MeshGap gap;
  // For touching parts this search finds the same points as the overlap did; twice the tolerance covers its
  // rounding.
  if (!haptics::nearestPoints(a, b, touches ? 2.0 * haptics::touchTolerance(a, b) : clearance, gap))
    return {};
  clash.kind = touches ? ClashKind::touch : ClashKind::clearance;
  clash.distance = touches ? 0.0 : gap.distance;
  clash.onA = gap.onA;
  clash.onB = gap.onB;
  clash.facetSag = sagOf(a, b, clash);
  return clash;
}

/// By the file, a shaft in a bore of its radius touches it. What contact gives such a fit is no clearance.
void settleEqualFit(const assets::Scene& scene, const Pose& worldFromA, const Pose& worldFromB,
                    Clash& clash) {
  if (clash.kind != ClashKind::clearance || !assets::hasEqualFits(scene) ||
      clash.distance > assets::widestEqualFit(scene, clash.a, clash.b) ||
      !assets::isInEqualFit(scene, clash.a, worldFromA, clash.b, worldFromB, clash.onA))
    return;
  clash.kind = ClashKind::touch;
  clash.distance = 0.0;
}

/// Nothing where the parts are further apart than `clearance`.
std::optional<Clash> measureNear(const PartClosings& closings, PartId a, const Pose& worldFromA, PartId b,
                                 const Pose& worldFromB, double clearance) {
  const assets::Scene& scene = closings.contact().scene();
  const double reach = assets::hasEqualFits(scene) ? assets::widestEqualFit(scene, a, b) : 0.0;
  std::optional<Clash> clash = measure(standing(closings, a, worldFromA), standing(closings, b, worldFromB),
                                       std::max(clearance, reach));
  if (!clash) return {};
  clash->a = a;
  clash->b = b;
  clash->mayCollide = assets::mayCollide(scene, a, b);
  settleEqualFit(scene, worldFromA, worldFromB, *clash);
  if (clash->kind == ClashKind::clearance && clash->distance > clearance) return {};
  return clash;
}

bool moreSevere(const Clash& l, const Clash& r) {
  if (l.mayCollide != r.mayCollide) return l.mayCollide;
  if (l.kind != r.kind) return l.kind < r.kind;
  if (l.open != r.open) return r.open;
  if (l.depth != r.depth) return l.depth > r.depth;
  if (l.distance != r.distance) return l.distance < r.distance;
  return l.a != r.a ? l.a < r.a : l.b < r.b;
}

}  // namespace

std::optional<Clash> measurePair(const PartClosings& closings, PartId a, const Pose& worldFromA, PartId b,
                                 const Pose& worldFromB) {
  const haptics::ContactScene& contact = closings.contact();
  if (treeOf(contact, a) == nullptr || treeOf(contact, b) == nullptr) return {};
  return measureNear(closings, a, worldFromA, b, worldFromB, std::numeric_limits<double>::max());
}

std::optional<Clash> nearestPart(const PartClosings& closings, PartId part,
                                 std::span<const Pose> worldFromPart) {
  const haptics::ContactScene& contact = closings.contact();
  ASSERT(worldFromPart.size() == contact.scene().parts.size());
  const TriangleBvh* own = treeOf(contact, part);
  if (own == nullptr) return {};
  const Standing placed = standing(closings, part, worldFromPart[part]);
  const assets::Bounds box = haptics::boundsAt(own->bounds(), worldFromPart[part]);
  struct Candidate {
    double atLeast;  // m, from box to box
    PartId part;
  };
  std::vector<Candidate> candidates;
  for (PartId other = 0; other < worldFromPart.size(); ++other) {
    const TriangleBvh* tree = other == part ? nullptr : treeOf(contact, other);
    if (tree == nullptr || !assets::mayCollide(contact.scene(), part, other)) continue;
    candidates.push_back({gapOf(box, haptics::boundsAt(tree->bounds(), worldFromPart[other])), other});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& l, const Candidate& r) {
    return l.atLeast != r.atLeast ? l.atLeast < r.atLeast : l.part < r.part;
  });
  std::optional<Clash> best;
  double reach = std::numeric_limits<double>::max();
  for (const Candidate& candidate : candidates) {
    if (candidate.atLeast > reach) break;
    const Standing other = standing(closings, candidate.part, worldFromPart[candidate.part]);
    haptics::MeshGap gap;
    const bool near = haptics::nearestPoints(placed.mesh, other.mesh, reach, gap);
    const bool meets = near && gap.distance <= haptics::touchTolerance(placed.mesh, other.mesh);
    const bool mayHold = candidate.atLeast <= 0.0 && (oneHolds(placed, other) || oneHolds(other, placed));
    if (!near && !mayHold) continue;
    Clash clash{part, candidate.part};
    clash.distance = gap.distance;
    clash.onA = gap.onA;
    clash.onB = gap.onB;
    if (meets || mayHold) clash = measure(placed, other, reach).value_or(clash);
    clash.a = part;
    clash.b = candidate.part;
    settleEqualFit(contact.scene(), worldFromPart[part], worldFromPart[candidate.part], clash);
    if (clash.kind != ClashKind::clearance) return clash;
    if (!near) continue;
    best = clash;
    reach = gap.distance;
  }
  return best;
}

ClashReport findClashes(const haptics::ContactScene& contact, const ClashOptions& options) {
  ASSERT(options.clearance >= 0.0);
  const Poses worldFromPart(contact, options.worldFromPart);
  const PartClosings closings(contact);
  const std::vector<Pair> pairs = nearPairs(contact, worldFromPart, options.clearance);
  const auto stopped = [&] { return options.stop != nullptr && options.stop->load(); };
  std::vector<std::optional<Clash>> found(pairs.size());
  std::atomic<std::size_t> next{0}, done{0};
  const int cores =
      options.threads > 0 ? options.threads : static_cast<int>(std::thread::hardware_concurrency());
  haptics::onThreads(std::max(1, cores), [&](int worker) {
    for (std::size_t i = next++; i < pairs.size() && !stopped(); i = next++) {
      const auto [a, b, triangles] = pairs[i];
      found[i] = measureNear(closings, a, worldFromPart[a], b, worldFromPart[b], options.clearance);
      ++done;
      if (worker == 0 && options.progress) options.progress(done, pairs.size());
    }
  });
  ClashReport report;
  ASSERT(done <= pairs.size());
  report.pairs = pairs.size();
  report.complete = done == pairs.size();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!found[i]) continue;
    Clash& clash = report.clashes.emplace_back(*found[i]);
    if (clash.kind == ClashKind::hard && !clash.open && clash.depth <= options.tolerance)
      clash.kind = ClashKind::touch;
  }
  std::sort(report.clashes.begin(), report.clashes.end(), moreSevere);
  return report;
}

}  // namespace tandem::client
