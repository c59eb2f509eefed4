#include "client/hand/near_parts.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/gltf/part_mass.h"
#include "assets/scene/part_pairs.h"
#include "haptics/geometry/placed_bounds.h"

namespace tandem::client {
namespace {

assets::Bounds boxOf(const assets::Scene& scene, const assets::Part& part) {
  if (part.shapes.empty())
    return part.mesh != assets::kNone ? scene.meshes[part.mesh].bounds : assets::Bounds{};
  assets::Bounds box;
  for (const assets::ImplicitShape& shape : part.shapes) {
    const assets::Bounds one = assets::shapeBounds(shape);
    box.include(one);
  }
  return box;
}

}  // namespace

NearParts::NearParts(const assets::Scene& scene) : scene_(scene) {
  for (const assets::Part& part : scene.parts) boxes_.push_back(boxOf(scene, part));
}

bool NearParts::meet(const Moving& held, const Moving& other, double playOutDelay, double near) const {
  if (!assets::mayCollide(scene_, held.part, other.part)) return false;
  const assets::Bounds a = haptics::boundsAt(boxes_[held.part], held.worldFromPart);
  const assets::Bounds b = haptics::boundsAt(boxes_[other.part], other.worldFromPart);
  const double gap = glm::length(glm::max(glm::dvec3(0.0), glm::max(a.min - b.max, b.min - a.max)));
  const glm::dvec3 between = 0.5 * (b.min + b.max - a.min - a.max);
  const double distance = glm::length(between);
  const double closing =
      distance > 0.0 ? glm::dot(held.twist.linear - other.twist.linear, between) / distance : 0.0;
  return gap < near + std::clamp(closing, kSetOut, kMaxClosing) * (2.0 * playOutDelay + kFadeTime);
}

}  // namespace tandem::client
