#pragma once

// The data of a ContactScene, for the sources of this folder and their tests.

#include <cstdint>
#include <memory>
#include <vector>

#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/contact_scene.h"
#include "haptics/scene/part_model.h"
#include "haptics/scene/part_tolerance.h"

namespace tandem::haptics {

/// The contact geometry of one part; instances share the tree.
struct Collider {
  const TriangleBvh* tree = nullptr;  // null: the part has no contact geometry
  glm::dvec3 centre{0.0, 0.0, 0.0};   // m, part frame, of the bounding box
  double radius = 0.0;                // m, of a ball around that centre that contains the part
  double skin = 0.0;                  // m, distance kept from the surface; see skinOf() in contact_scene.cpp
  double leastTool = 0.0;             // m, least radius of a swept tool; see leastToolOf() there
  const PartModel* model = nullptr;   // null: held parts pass through it

  bool operator==(const Collider&) const = default;
};

struct SurfaceScene;  // surface_scene.h

struct ContactScene::Data {
  Data();
  Data(const Data&);
  ~Data();
  /// Derives the colliders of the parts that use a mesh, and the surfaces.
  void measure(std::uint32_t mesh);
  /// m, diagonal of the smallest part that a hand can hold; infinite if there is none.
  double smallestHeld() const;
  /// m, of each tree: parts that share a mesh share its model, so the strictest part decides.
  std::vector<double> treeTolerances(const std::vector<PartTolerance>& ofParts) const;

  const assets::Scene* scene = nullptr;
  double leastToolShare = 0.0;
  std::vector<std::shared_ptr<const assets::Mesh>> shapeMeshes;  // tessellated implicit shapes
  std::vector<std::vector<assets::ImplicitShape>> shapes;  // one a tree, of finite extents; empty for a mesh
  std::vector<std::shared_ptr<const assets::Mesh>> replacements;  // a scene mesh: what stands for it, or null
  std::vector<std::shared_ptr<TriangleBvh>> trees;  // scene meshes first, in order; null if no part uses one
  /// One a tree, or none at all; null for a mesh that was exchanged or refitted.
  std::vector<std::shared_ptr<const PartModel>> models;
  std::vector<Collider> colliders;        // one a part
  std::vector<PartTolerance> tolerances;  // one a part once models exist, else none
  std::vector<bool> deformed;             // one a scene mesh: refitted, so that its normals do not hold
  std::shared_ptr<const SurfaceScene> surfaces;  // null: no material has surface effects
};

}  // namespace tandem::haptics
