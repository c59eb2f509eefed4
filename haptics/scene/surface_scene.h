#pragma once

// Surface data of a scene beyond its triangles, made once. A scene whose materials need no surface effects
// has no SurfaceScene.

#include <cstdint>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/corner_normals.h"

namespace tandem::haptics {

/// The faces of a mesh that have one magnetic surface.
struct Magnet {
  std::uint32_t surface = 0;          // into the scene's surfaces
  const TriangleBvh* tree = nullptr;  // of these faces; that of the mesh if it has no others
};

/// Faces of a mesh with a tree of their own.
struct SomeFaces {
  explicit SomeFaces(assets::Mesh faces) : mesh(std::move(faces)), tree(mesh) {}
  SomeFaces(const SomeFaces&) = delete;
  const assets::Mesh mesh;
  const TriangleBvh tree;
};

/// Surface data of one part.
struct PartSurface {
  const ShadedMesh* shaded = nullptr;  // null: flat facets
  double reach = 0.0;       // m above the triangles within which its patches, relief or pull may act
  double forceReach = 0.0;  // N, of relief given as a force; the tool's stiffness converts it to reach
  const std::vector<Magnet>* magnets = nullptr;  // null: none
  bool any = false;  // some material of the part has a surface, or normals of the file are felt
};

struct SurfaceScene {
  std::vector<std::unique_ptr<ShadedMesh>> shaded;
  std::vector<std::unique_ptr<const std::vector<Magnet>>> magnets;  // of one mesh each
  std::vector<std::unique_ptr<SomeFaces>> faces;                    // of meshes that are magnets in part
  std::vector<PartSurface> parts;                                   // one per part
  double reach = 0.0, forceReach = 0.0;                             // maxima over all parts
  double magneticReach = 0.0;  // m, the longest of all magnets; 0: there are none
};

/// Null if no part's material has a surface and no mesh has normals. `deformed`: the trees whose points have
/// moved since the mesh's normals were stated; these do not hold any more.
std::unique_ptr<SurfaceScene> makeSurfaceScene(const assets::Scene& scene,
                                               const std::vector<Collider>& colliders,
                                               const std::set<const TriangleBvh*>& deformed = {});

}  // namespace tandem::haptics
