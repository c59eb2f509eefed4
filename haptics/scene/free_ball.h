#pragma once

// Free space kept from tick to tick: a ball that no surface which the tool may touch reaches into. While the
// tool stays in it a tick needs no query. Whatever may bring a surface nearer shrinks the ball at once.

#include <algorithm>
#include <cstdint>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "assets/scene/scene.h"

namespace tandem::haptics {

class FreeBall {
 public:
  /// The ball from now on; `radius` m is a lower bound of the distance to any surface.
  void keep(const glm::dvec3& centre, double radius) {
    ++changes_;
    centre_ = centre;
    radius_ = radius;
  }
  void forget() {
    ++changes_;
    radius_ = 0.0;
  }

  /// Whether a ball of `radius` m around p is in the kept one.
  bool contains(const glm::dvec3& p, double radius) const {
    return radius_ > 0.0 && glm::distance(p, centre_) + radius < radius_;
  }
  const glm::dvec3& centre() const { return centre_; }
  double radius() const { return radius_; }
  /// Grows with every call that may change something: equal while no surface has moved.
  std::uint64_t changes() const { return changes_; }

  /// A surface may now be anywhere in `box`, m, world.
  void exclude(const assets::Bounds& box) {
    ++changes_;
    if (!(radius_ > 0.0)) return;
    radius_ = std::min(radius_, glm::distance(centre_, glm::clamp(centre_, box.min, box.max)));
  }
  /// Surfaces may now be anywhere outside `box`.
  void confineTo(const assets::Bounds& box) {
    ++changes_;
    if (!(radius_ > 0.0)) return;
    const glm::dvec3 room = glm::min(centre_ - box.min, box.max - centre_);
    radius_ = std::max(0.0, std::min({radius_, room.x, room.y, room.z}));
  }

 private:
  glm::dvec3 centre_{0.0, 0.0, 0.0};  // m, world
  double radius_ = 0.0;               // m; 0: none is known
  std::uint64_t changes_ = 0;
};

}  // namespace tandem::haptics
