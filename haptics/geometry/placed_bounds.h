#pragma once

// The axis-aligned box around a rotated box.

#include <glm/common.hpp>

#include "assets/base/pose.h"
#include "assets/scene/scene.h"

namespace tandem::haptics {

/// The box in the target frame of `pose`.
inline assets::Bounds boundsAt(const assets::Bounds& own, const Pose& pose) {
  assets::Bounds box;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 p =
        transformPoint(pose, {(i & 1) != 0 ? own.max.x : own.min.x, (i & 2) != 0 ? own.max.y : own.min.y,
                              (i & 4) != 0 ? own.max.z : own.min.z});
    box.include(p);
  }
  return box;
}

}  // namespace tandem::haptics
