#pragma once

// Surface data of a scene beyond its triangles, made once. A scene whose materials need no surface effects
// has no SurfaceScene.

#include <memory>
#include <vector>

#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/force_shading.h"

namespace tandem::haptics {

/// Surface data of one part.
struct PartSurface {
  const ShadedMesh* shaded = nullptr;  // null: flat facets
  double reach = 0.0;       // m above the triangles within which its patches, relief or pull may act
  double forceReach = 0.0;  // N, of relief given as a force; the tool's stiffness converts it to reach
  bool any = false;         // some material of the part has a surface
};

struct SurfaceScene {
  std::vector<std::unique_ptr<ShadedMesh>> shaded;
  std::vector<PartSurface> parts;        // one per part
  double reach = 0.0, forceReach = 0.0;  // maxima over all parts
};

/// Null if no part's material has a surface.
std::unique_ptr<SurfaceScene> makeSurfaceScene(const assets::Scene& scene,
                                               const std::vector<Collider>& colliders);

}  // namespace tandem::haptics
