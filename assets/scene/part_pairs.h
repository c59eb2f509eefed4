#pragma once

// Which parts of a scene may touch each other.

#include <algorithm>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// Whether two parts may touch, by the filters of both and the joints between them.
inline bool mayCollide(const Scene& scene, PartId a, PartId b) {
  return mayCollide(scene.parts[a].filter, scene.parts[b].filter) &&
         std::none_of(scene.joints.begin(), scene.joints.end(), [a, b](const Joint& joint) {
           return !joint.collide &&
                  ((joint.partA == a && joint.partB == b) || (joint.partA == b && joint.partB == a));
         });
}

}  // namespace tandem::assets
