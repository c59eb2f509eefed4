#include "client/marks/exploded_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::client {
namespace {

using assets::Bounds;

constexpr double kSpread = 0.6;       // of a member's way from the middle, which it moves on at least
constexpr double kSpreadMany = 1.5;   // the same where members are too many to be kept from overlapping
constexpr double kBoxGap = 0.08;      // of the smaller box's diagonal, between two boxes
constexpr double kAsFar = 0.25;       // share of the main direction from which an axis is a way out too
constexpr double kWellWithin = 0.02;  // of a box that is around the middle: how far inside of it that is
constexpr double kConcentric =
    1e-3;  // of the group's size: nearer to its middle, no direction is a member's own

bool hasNoBox(const Bounds& box) { return !(box.min.x <= box.max.x); }
glm::dvec3 middle(const Bounds& box) { return 0.5 * (box.min + box.max); }
glm::dvec3 extentOf(const Bounds& box) { return box.max - box.min; }

Bounds shifted(const Bounds& box, const glm::dvec3& by) { return {box.min + by, box.max + by}; }

/// A part, or a group that is already drawn apart.
struct Member {
  Bounds now, apart;        // before anything is moved, and once its own members are apart
  glm::dvec3 way{0.0};      // that it moves
  double fromMiddle = 0.0;  // m
};

/// How far a box has to go in a direction (unit) until it is clear of all of these.
double distanceOut(const Bounds& box, const glm::dvec3& direction, std::span<const Bounds> placed) {
  double distance = 0.0;
  for (bool clear = false; !clear;) {
    clear = true;
    const Bounds here = shifted(box, distance * direction);
    for (const Bounds& other : placed) {
      const double gap = kBoxGap * std::min(glm::length(extentOf(here)), glm::length(extentOf(other)));
      double leaves = std::numeric_limits<double>::infinity();
      bool overlaps = true;
      for (int axis = 0; axis < 3 && overlaps; ++axis) {
        const double ahead = other.max[axis] + gap - here.min[axis],
                     behind = here.max[axis] + gap - other.min[axis];
        overlaps = ahead > 0.0 && behind > 0.0;
        if (direction[axis] > 0.0) leaves = std::min(leaves, ahead / direction[axis]);
        if (direction[axis] < 0.0) leaves = std::min(leaves, behind / -direction[axis]);
      }
      if (!overlaps) continue;
      distance += leaves * (1.0 + 1e-9) + 1e-12;
      clear = false;
      break;
    }
  }
  return distance;
}

/// The directions in which a member may leave the others: that from the group's middle, and the axes that
/// point the same way. One in the middle may leave along any axis.
std::vector<glm::dvec3> waysOut(const glm::dvec3& fromMiddle, const glm::dvec3& half) {
  std::vector<glm::dvec3> ways;
  const glm::dvec3 share = fromMiddle / glm::max(half, glm::dvec3(1e-12));
  const double most = std::max({std::abs(share.x), std::abs(share.y), std::abs(share.z)});
  const bool concentric = glm::length(fromMiddle) < kConcentric * glm::length(half);
  if (!concentric) ways.push_back(glm::normalize(fromMiddle));
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 along(0.0);
    along[axis] = fromMiddle[axis] < 0.0 ? -1.0 : 1.0;
    if (concentric || std::abs(share[axis]) >= kAsFar * most) ways.push_back(along);
    if (concentric) ways.push_back(-along);
  }
  return ways;
}

/// Moves the members of one group apart. The largest one around the middle stays there; the others find
/// their places from the middle outwards.
void moveApart(std::vector<Member>& members) {
  Bounds all;
  for (const Member& member : members) all.include(member.now);
  const glm::dvec3 centre = middle(all), half = 0.5 * extentOf(all);
  std::vector<std::size_t> order(members.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::size_t base = members.size();
  double largest = 0.0;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Bounds& box = members[i].now;
    members[i].fromMiddle = glm::length(middle(box) - centre);
    const glm::dvec3 within = kWellWithin * extentOf(box);
    const bool around = glm::all(glm::lessThan(box.min + within, centre)) &&
                        glm::all(glm::lessThan(centre, box.max - within));
    if (!around || glm::length(extentOf(box)) <= largest) continue;
    largest = glm::length(extentOf(box));
    base = i;
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if ((a == base) != (b == base)) return a == base;
    return members[a].fromMiddle < members[b].fromMiddle;
  });
  const bool many = members.size() > kMostMembers;
  std::vector<Bounds> placed;
  for (const std::size_t i : order) {
    Member& member = members[i];
    const glm::dvec3 fromMiddle = middle(member.now) - centre;
    if (i != base) member.way = (many ? kSpreadMany : kSpread) * fromMiddle;
    if (many) continue;
    const Bounds box = shifted(member.apart, member.way);
    double least = std::numeric_limits<double>::infinity();
    glm::dvec3 out(0.0);
    for (const glm::dvec3& direction : waysOut(fromMiddle, half)) {
      const double distance = distanceOut(box, direction, placed);
      if (distance >= least * (1.0 - 1e-9)) continue;
      least = distance;
      out = distance * direction;
    }
    member.way += out;
    placed.push_back(shifted(member.apart, member.way));
  }
}

/// The groups of a scene's tree, from the innermost one outwards.
class Groups {
 public:
  Groups(const assets::Scene& scene, std::span<const Bounds> boxes, std::span<const PartId> apart)
      : scene_(scene), boxes_(boxes), partsOf_(scene.tree.size() + 1), groupsOf_(scene.tree.size() + 1) {
    std::vector<bool> moves(scene.parts.size(), apart.empty());
    for (const PartId part : apart)
      if (part < moves.size()) moves[part] = true;
    for (std::size_t part = 0; part < moves.size(); ++part)
      if (moves[part] && !hasNoBox(boxes[part]))
        partsOf_[groupAt(scene.parts[part].treeNode)].push_back(part);
    for (std::size_t node = 0; node < scene.tree.size(); ++node)
      groupsOf_[groupAt(scene.tree[node].parent)].push_back(node);
  }

  std::vector<glm::dvec3> ways() {
    const std::size_t all = scene_.tree.size();
    std::vector<glm::dvec3> ways(scene_.parts.size(), glm::dvec3(0.0)), wayOfGroup(all + 1, glm::dvec3(0.0));
    std::vector<Member> groups(all + 1);
    std::vector<std::vector<Member>> members(all + 1);
    for (std::size_t i = 0; i <= all; ++i) {
      const std::size_t group = i < all ? all - 1 - i : all;  // those inside of others first
      std::vector<Member>& own = members[group];
      for (const std::size_t part : partsOf_[group]) own.push_back({boxes_[part], boxes_[part]});
      for (const std::size_t inner : groupsOf_[group]) own.push_back(groups[inner]);
      std::vector<Member> there = own;
      std::erase_if(there, [](const Member& member) { return hasNoBox(member.now); });
      if (there.size() > 1) {
        moveApart(there);
        std::size_t next = 0;
        for (Member& member : own)
          if (!hasNoBox(member.now)) member = there[next++];
      }
      for (const Member& member : own) {
        groups[group].now.include(member.now);
        groups[group].apart.include(shifted(member.apart, member.way));
      }
    }
    for (std::size_t i = 0; i <= all; ++i) {
      const std::size_t group = i == 0 ? all : i - 1;  // those around others first
      std::size_t next = 0;
      for (const std::size_t part : partsOf_[group])
        ways[part] = wayOfGroup[group] + members[group][next++].way;
      for (const std::size_t inner : groupsOf_[group])
        wayOfGroup[inner] = wayOfGroup[group] + members[group][next++].way;
    }
    return ways;
  }

 private:
  /// The place of a tree's node in the lists; the last one is the scene as a whole.
  std::size_t groupAt(std::uint32_t node) const { return std::min<std::size_t>(node, scene_.tree.size()); }

  const assets::Scene& scene_;
  std::span<const Bounds> boxes_;
  std::vector<std::vector<std::size_t>> partsOf_, groupsOf_;
};

}  // namespace

std::vector<glm::dvec3> waysApart(const assets::Scene& scene, std::span<const Bounds> boxes,
                                  std::span<const PartId> apart) {
  ASSERT(boxes.size() == scene.parts.size());
  return Groups(scene, boxes, apart).ways();
}

void ExplodedScene::findWays(const ViewModel& model, const std::vector<PartId>& apart,
                             const SceneRenderer& renderer) {
  std::vector<Bounds> boxes;
  for (std::size_t p = 0; p < model.worldFromPart.size(); ++p)
    boxes.push_back(renderer.bounds(model.worldFromPart, std::array{static_cast<PartId>(p)}));
  ways_ = waysApart(*model.scene, boxes, apart);
  apart_ = apart;
}

const ViewModel& ExplodedScene::drawn(const ViewModel& model, const document::PartStyle& style,
                                      const SceneRenderer& renderer) {
  if (!(style.explode > 0.0)) {
    ways_.clear();
    return model;
  }
  if (ways_.size() != model.worldFromPart.size() || apart_ != style.apart)
    findWays(model, style.apart, renderer);
  drawn_ = model;
  for (std::size_t p = 0; p < ways_.size(); ++p) drawn_.worldFromPart[p].position += style.explode * ways_[p];
  for (SiteView& site : drawn_.sites)
    if (site.presence.touched < ways_.size())
      site.presence.worldFromTool.position += style.explode * ways_[site.presence.touched];
  // What is measured is where parts are, not where they are drawn.
  drawn_.measure.places.clear();
  drawn_.measure.figures.clear();
  return drawn_;
}

}  // namespace tandem::client
