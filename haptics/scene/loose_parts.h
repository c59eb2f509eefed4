#pragma once

// Parts that move by the thousand, kept out of the scene tree: refitting it for each of them costs 130 ns,
// near the tool or not. A tick names the region that it is going to ask about; a part that moves outside of
// it costs a comparison and the storing of its pose.
//
// 1. Free of allocation after construction. One a ContactWorld.
//
// 2. A part is loose from the tick in which it moves until it has been put back into the tree, which happens
//    a few parts a tick once they stand still.

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
    assets::Bounds box;  // m, world: where the part is, and where it was when the tick began
  };

  LooseParts() = default;
  explicit LooseParts(std::size_t parts);
  /// The largest distance of a part's geometry from its origin, m; below 0 without geometry.
  void setReach(PartId part, double reach) { reach_[part] = reach; }

  bool isLoose(PartId part) const { return movedIn_[part] != 0; }
  bool any() const { return !ids_.empty(); }

  /// Begins a tick: nothing is near yet.
  void begin(const assets::Bounds& region) {
    region_ = region;
    near_.clear();
    widened_ = false;
    listed_ = 0;
    if (++now_ == 0) now_ = 1;
  }

  /// Makes a part loose that moves in this tick from `before` to `after`. True if it may come into the
  /// region in this tick or, at that speed, in the next: then addNear() must follow.
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

  /// After the region was widened in the midst of a tick: the part is in `box` from now on.
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
  /// Calls visit(part) for every loose part that has not moved in this tick; the part may be dropped
  /// meanwhile.
  template <typename Visit>
  void forEachAtRest(Visit&& visit) {
    for (std::size_t i = ids_.size(); i-- > 0;) {
      if (movedIn_[ids_[i]] != now_) visit(ids_[i]);
    }
  }

  /// Widens the region to hold `box`; calls visit(part) for every loose part that may now be near, for
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
  /// Forgets a part: it is in the tree again.
  void drop(PartId part);

 private:
  bool within(const glm::dvec3& p, double limit) const {
    return p.x + limit >= region_.min.x && p.x - limit <= region_.max.x && p.y + limit >= region_.min.y &&
           p.y - limit <= region_.max.y && p.z + limit >= region_.min.z && p.z - limit <= region_.max.z;
  }
  void loosen(PartId part);

  std::vector<double> reach_;           // m, a part
  std::vector<std::uint32_t> movedIn_;  // a part: the tick in which it last moved, 0 = in the tree
  std::vector<std::uint32_t> slot_;     // a part: where it stands in ids_
  std::vector<PartId> ids_;             // the loose parts; capacity for all
  std::vector<Near> near_;              // capacity for all
  assets::Bounds region_;               // m, world
  bool widened_ = false;
  std::uint32_t now_ = 1;
  std::size_t listed_ = 0;  // loose parts that have moved in this tick
};

}  // namespace tandem::haptics
