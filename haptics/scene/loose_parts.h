#pragma once

// Keeps thousands of moving parts out of the scene tree, because a refit for each of them costs 130 ns, near
// the tool or not. A tick names the region that it will query; a part that moves outside of it costs a
// comparison and a store of its pose.
//
// 1. Free of allocation after construction. One per ContactWorld.
// 2. A part is loose from the tick in which it moves until it returns to the tree; a few parts return per
//    tick once they rest.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "assets/base/ids.h"
#include "assets/base/pose.h"
#include "assets/scene/scene.h"
#include "haptics/geometry/scene_bvh.h"

namespace tandem::haptics {

class LooseParts {
 public:
  struct Near {
    PartId part;
    assets::Bounds box;  // m, world: present box and that at the start of the tick
  };

  LooseParts() = default;
  explicit LooseParts(std::size_t parts);
  /// Greatest distance of a part's geometry from its origin, m; negative without geometry.
  void setReach(PartId part, double reach) { reach_[part] = reach; }

  bool isLoose(PartId part) const { return movedIn_[part] != 0; }
  bool any() const { return !ids_.empty(); }

  /// Begins a tick with no part near.
  void begin(const assets::Bounds& region) {
    region_ = region;
    near_.clear();
    widened_ = false;
    listed_ = 0;
    if (++now_ == 0) now_ = 1;
  }

  /// Makes a part loose that moves in this tick from `before` to `after`. True if it may enter the region in
  /// this tick or, at that speed, in the next one; addNear() must then follow.
  bool note(PartId part, const glm::dvec3& before, const glm::dvec3& after) {
    if (reach_[part] < 0.0) return false;
    if (movedIn_[part] == 0) loosen(part);
    listed_ += movedIn_[part] != now_ ? 1u : 0u;
    movedIn_[part] = now_;
    const double step =
        std::abs(after.x - before.x) + std::abs(after.y - before.y) + std::abs(after.z - before.z);
    return within(after, reach_[part] + 2.0 * step);
  }
  void addNear(PartId part, const assets::Bounds& box) {
    if (near_.size() < near_.capacity()) near_.push_back({part, box});
  }

  /// Adds a part with this box after the region was widened during a tick.
  void renew(PartId part, const assets::Bounds& box) {
    for (Near& near : near_) {
      if (near.part == part) {
        near.box = box;
        return;
      }
    }
    addNear(part, box);
  }
  bool widened() const { return widened_; }

  /// Whether some loose parts have not moved in this tick.
  bool anyAtRest() const { return listed_ < ids_.size(); }
  /// Calls visit(part) for every loose part that has not moved in this tick; visit may drop the part.
  template <typename Visit>
  void forEachAtRest(Visit&& visit) {
    for (std::size_t i = ids_.size(); i-- > 0;) {
      if (movedIn_[ids_[i]] != now_) visit(ids_[i]);
    }
  }

  /// Widens the region to contain `box` and calls visit(part) for every loose part that may now be near, for
  /// addNear().
  template <typename PositionOf, typename Visit>
  void widen(const assets::Bounds& box, PositionOf&& positionOf, Visit&& visit) {
    const glm::dvec3 grow = 0.5 * (box.max - box.min);
    region_ = {glm::min(region_.min, box.min - grow), glm::max(region_.max, box.max + grow)};
    near_.clear();
    widened_ = true;
    for (const PartId part : ids_) {
      if (within(positionOf(part), reach_[part])) visit(part);
    }
  }
  bool covers(const assets::Bounds& box) const {
    return region_.min.x <= box.min.x && region_.min.y <= box.min.y && region_.min.z <= box.min.z &&
           region_.max.x >= box.max.x && region_.max.y >= box.max.y && region_.max.z >= box.max.z;
  }
  bool within(PartId part, const glm::dvec3& position) const { return within(position, reach_[part]); }

  const std::vector<Near>& near() const { return near_; }
  /// Removes a part that has returned to the tree.
  void drop(PartId part);

 private:
  bool within(const glm::dvec3& p, double limit) const {
    return p.x + limit >= region_.min.x && p.x - limit <= region_.max.x && p.y + limit >= region_.min.y &&
           p.y - limit <= region_.max.y && p.z + limit >= region_.min.z && p.z - limit <= region_.max.z;
  }
  void loosen(PartId part);

  std::vector<double> reach_;           // m, per part
  std::vector<std::uint32_t> movedIn_;  // per part: the tick of its last motion, 0 = in the tree
  std::vector<std::uint32_t> slot_;     // per part: its place in ids_
  std::vector<PartId> ids_;             // the loose parts; capacity for all
  std::vector<Near> near_;              // capacity for all
  assets::Bounds region_;               // m, world
  bool widened_ = false;
  std::uint32_t now_ = 1;
  std::size_t listed_ = 0;  // loose parts that have moved in this tick
};

}  // namespace tandem::haptics
