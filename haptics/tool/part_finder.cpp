#include "haptics/tool/part_finder.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

// A search looks this many times as far as a part's reach: the room that it finds lasts for more ticks.
constexpr double kAhead = 2.0;
constexpr int kFewQueries = 4;      // of a search that may look ahead
constexpr double kRounding = 1e-9;  // share of a distance that two ways to compute it never differ by

double touchReach(const Collider& collider, double radius) {
  return radius + std::max(2.0 * radius, kTouchShare * 2.0 * collider.radius);
}

/// Whether a part's bounding ball is farther than `reach` m from p.
bool isBeyond(const ContactWorld& world, PartId part, const glm::dvec3& p, double reach) {
  const Collider& collider = world.collider(part);
  const glm::dvec3 centre = transformPoint(world.pose(part), collider.centre);
  return glm::length(centre - p) > collider.radius + reach;
}

assets::Bounds boxAround(const glm::dvec3& p, double half) {
  return {p - glm::dvec3(half), p + glm::dvec3(half)};
}

/// Where some triangle of a part is, m from p: no nearer than the part's nearest one.
double distanceOf(const ContactWorld& world, PartId part, std::uint32_t triangle, const glm::dvec3& p) {
  return glm::distance(p, world.surfaceAt(part, triangle, p).point) * (1.0 + kRounding);
}

/// A pass over the parts around a place by their trees' leaves, which decides unless two parts are almost
/// equally near, or one is about to be out of its reach.
struct RoughPass {
  const ContactWorld& world;
  const glm::dvec3 p;
  const double radius;
  const double ahead;  // factor on each part's reach while no part is found

  PartId under = kNoPart;  // certainly within its reach
  std::uint32_t triangle = kNoTriangle;
  double atMost = 1e300;  // m, of the distance of `under`
  // Of the parts that may be within their reach, the two whose distances have the least bounds, m.
  double atLeast[2] = {1e300, 1e300};
  PartId near = kNoPart;  // the first of them
  int queries = 0;
  double free = 1e300;  // m, within which there is no surface with its margin
  double room = 1e300;  // m, by which every surface is out of its part's reach; negative if one may not be

  void visit(PartId part) {
    if (!world.touchable(part) || queries > kMaxTouchQueries) return;
    const double own = touchReach(world.collider(part), radius);
    const double reach = under == kNoPart ? ahead * own : std::min(atMost, own);
    if (isBeyond(world, part, p, reach)) return note(part, reach, own);
    if (++queries > kMaxTouchQueries) return;
    const NearLeaf leaf = world.nearestLeaf(part, p, reach);
    note(part, leaf.atLeast, own);
    if (leaf.triangle == kNoTriangle || leaf.atLeast > own) return;
    const bool first = leaf.atLeast < atLeast[0];
    if (first) near = part;
    atLeast[1] = first ? atLeast[0] : std::min(atLeast[1], leaf.atLeast);
    if (first) atLeast[0] = leaf.atLeast;
    const double distance = distanceOf(world, part, leaf.triangle, p);
    if (distance >= own || distance >= atMost) return;
    atMost = distance;
    under = part;
    triangle = leaf.triangle;
  }
  /// Whether `under` is the answer, also where it is none.
  bool decides() const {
    if (queries > kMaxTouchQueries) return false;
    return under == kNoPart ? near == kNoPart : atMost < (near == under ? atLeast[1] : atLeast[0]);
  }

 private:
  void note(PartId part, double distance, double own) {
    free = std::min(free, distance - 2.0 * world.margin(part, p, 0.0));
    room = std::min(room, distance - own);
  }
};

/// A pass over the parts by their nearest points.
struct ExactPass {
  const ContactWorld& world;
  const glm::dvec3 p;
  const double radius;

  PartId under = kNoPart;
  std::uint32_t triangle = kNoTriangle;
  double nearest = 1e300;  // m, of `under`
  int queries = 0;

  void visit(PartId part) {
    if (!world.touchable(part) || queries == kMaxTouchQueries) return;
    const double reach = std::min(nearest, touchReach(world.collider(part), radius));
    if (isBeyond(world, part, p, reach)) return;
    ++queries;
    SurfacePoint found;
    if (!world.nearest(part, p, reach, found) || found.distance >= nearest) return;
    nearest = found.distance;
    under = part;
    triangle = found.triangle;
  }
};

}  // namespace

PartId PartFinder::find(ContactWorld& world, const glm::dvec3& p, double radius, double farthest) {
  if (world.freeBall().contains(p, farthest)) return kNoPart;
  if (isUndisturbed(world) && radius == radius_ && glm::distance(p, place_) < room_) return kNoPart;
  return isStillNearest(world, p, radius) ? part_ : search(world, p, radius, farthest);
}

/// Whether some triangle of the part found last is within reach, and every other part is farther away.
bool PartFinder::isStillNearest(const ContactWorld& world, const glm::dvec3& p, double radius) const {
  const bool known = world.has(part_) && world.touchable(part_) &&
                     triangle_ < world.collider(part_).tree->mesh().triangles.size();
  if (!known) return false;
  const double distance = distanceOf(world, part_, triangle_, p);
  if (distance >= touchReach(world.collider(part_), radius)) return false;
  int queries = 0;
  bool nearest = true;
  world.forEachNear(boxAround(p, distance), [&](PartId part) {
    if (part == part_ || !nearest || !world.touchable(part)) return;
    const double reach = std::min(distance, touchReach(world.collider(part), radius));
    if (isBeyond(world, part, p, reach)) return;
    SurfacePoint found;
    nearest = ++queries <= kMaxTouchQueries && !world.nearest(part, p, reach, found);
  });
  return nearest;
}

PartId PartFinder::search(ContactWorld& world, const glm::dvec3& p, double radius, double farthest) {
  // What is found ahead is of use only where nothing moves, and costs little only among few parts.
  const double ahead = isUndisturbed(world) && queries_ <= kFewQueries ? kAhead : 1.0;
  RoughPass rough{world, p, radius, ahead};
  world.forEachNear(boxAround(p, ahead * farthest), [&](PartId part) { rough.visit(part); });
  queries_ = rough.queries;
  const bool all = rough.queries <= kMaxTouchQueries;
  // Parts whose boxes are not met are farther away than half the box; their margins are part of their boxes.
  const double free = std::min(rough.free, ahead * farthest) * (1.0 - kRounding);
  world.keepFree(p, all ? free : 0.0);
  changes_ = world.freeBall().changes();
  place_ = p;
  radius_ = radius;
  room_ = all ? std::min(rough.room, (ahead - 1.0) * farthest) * (1.0 - kRounding) : 0.0;
  if (rough.decides()) return note(rough.under, rough.triangle);

  ExactPass exact{world, p, radius};
  world.forEachNear(boxAround(p, farthest), [&](PartId part) { exact.visit(part); });
  return note(exact.under, exact.triangle);
}

PartId PartFinder::note(PartId part, std::uint32_t triangle) {
  if (part == kNoPart) return kNoPart;
  part_ = part;
  triangle_ = triangle;
  return part;
}

}  // namespace tandem::haptics
