#pragma once

// Decides which nodes of a glTF file make up which part. In plain CAD each mesh node becomes a static part; a
// node with `motion` becomes a part with the geometry of all its descendants that have no motion of their
// own. For the loader's sources only.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "assets/gltf/gltf_geometry.h"
#include "assets/gltf/gltf_nodes.h"
#include "assets/gltf/gltf_physics.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// A part before its mesh has been read.
struct PartPlan {
  std::string name;            // unique
  std::uint32_t flatNode = 0;  // into the flat nodes, which are Scene::tree
  Pose worldFromPart;
  std::vector<MeshPiece> pieces;
  std::vector<ImplicitShape> shapes;    // m
  std::optional<PhysicsMotion> motion;  // file units
  std::optional<std::size_t> filter;    // into GltfPhysics::filters
  double contactTolerance = 0.0;        // m, the strictest of its nodes'; 0: none states one
  double density = 0.0;                 // kg/m^3, its node's or that of the nearest above; 0: none states one
  std::uint32_t geometry = kNone;       // into ScenePlan::geometries
};

/// The geometry to be read, and the parts that use it.
struct ScenePlan {
  std::vector<FlatNode> nodes;
  std::vector<PartPlan> parts;
  std::vector<std::vector<MeshPiece>> geometries;  // distinct piece lists; instances share one
  std::vector<std::uint32_t> partOfNode;  // a flat node: its part or that of its nearest ancestor, else kNone
  std::vector<Material> materials;
  std::vector<Surface> surfaces;  // texture.image is still a glTF texture
  std::vector<Finding> findings;
};

/// Plans all parts of the default scene. `unitScale` in m per file unit; more than `maxTriangles` in all
/// distinct geometries together is refused.
ScenePlan planParts(const GltfDocument& document, const GltfPhysics& physics, double unitScale,
                    std::size_t maxTriangles);

}  // namespace tandem::assets
