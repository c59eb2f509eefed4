#pragma once

// What the surfaces of a scene need beside its triangles, made once. A scene whose materials ask for nothing
// special has no SurfaceScene.

#include <memory>
#include <vector>

#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/force_shading.h"

namespace tandem::haptics {

/// What is special about one part.
struct PartSurface {
  const ShadedMesh* shaded = nullptr;  // null: flat facets
  double reach = 0.0;       // m above the triangles within which its patches, relief or pull may act
  double forceReach = 0.0;  // N, of relief given as a force: more reach, by the tool's stiffness
  bool any = false;         // some material of the part has a surface
};

struct SurfaceScene {
  std::vector<std::unique_ptr<ShadedMesh>> shaded;
  std::vector<PartSurface> parts;        // one a part
  double reach = 0.0, forceReach = 0.0;  // the largest of all parts
};

/// Null if no part's material has a surface.
std::unique_ptr<SurfaceScene> makeSurfaceScene(const assets::Scene& scene,
                                               const std::vector<Collider>& colliders);

}  // namespace tandem::haptics
