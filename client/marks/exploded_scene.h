#pragma once

// Parts drawn apart from each other. It is a picture alone: where parts are does not change.
//
// 1. Groups move away from the middle of the group that they are in, and parts within their groups, each in
//    the direction of its own middle from that one.
// 2. Drawn fully apart, the boxes of a group's members do not overlap, up to kMostMembers of them.
// 3. Where parts go is found when they begin to be drawn apart; a part that moves meanwhile moves from there.

#include <span>
#include <vector>

#include "client/marks/part_display.h"
#include "client/picture/scene_renderer.h"

namespace tandem::client {

inline constexpr std::size_t kMostMembers = 800;  // of a group, that are kept from overlapping

/// How far each part of the scene goes when it is drawn fully apart: m, world. `boxes` are those of the
/// parts, world; a part with an empty one stays. Of `apart` alone, from their middle, unless that is empty.
std::vector<glm::dvec3> waysApart(const assets::Scene& scene, std::span<const assets::Bounds> boxes,
                                  std::span<const PartId> apart);

class ExplodedScene {
 public:
  /// The model with its parts, and the hands at them, where they are drawn: `model` itself unless parts are
  /// drawn apart. Valid until the next call.
  const ViewModel& drawn(const ViewModel& model, const document::PartStyle& style,
                         const SceneRenderer& renderer);

 private:
  void findWays(const ViewModel& model, const std::vector<PartId>& apart, const SceneRenderer& renderer);

  ViewModel drawn_;
  std::vector<glm::dvec3> ways_;  // empty: parts are not drawn apart
  std::vector<PartId> apart_;     // that the ways are of
};

}  // namespace tandem::client
