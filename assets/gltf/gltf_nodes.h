#pragma once

// The node hierarchy of a glTF file as a flat list. For the loader's sources only.

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>

#include "assets/gltf/gltf_document.h"

namespace tandem::assets {

/// A node of the default scene.
struct FlatNode {
  std::size_t gltfNode = 0;       // into model.nodes
  std::uint32_t parent = 0;       // into the list, or kNone
  glm::dmat4 worldFromNode{1.0};  // m; holds the unit scale too
};

/// A mesh below some node, in that node's frame.
struct SubtreeMesh {
  std::size_t gltfNode = 0;
  glm::dmat4 rootFromNode{1.0};
};

/// The nodes of the default scene, parents before their children, depth first. Refuses cycles, nodes with two
/// parents and transforms that are not finite, anywhere in the file. `unitScale` is m per file unit.
std::vector<FlatNode> flattenNodes(const GltfDocument& document, double unitScale);

/// The nodes with meshes of the subtree at `root`, including `root` without its own transform. The file must
/// have passed flattenNodes(). Each visited node reduces `budget`, because many colliders may name one large
/// subtree; a file that exhausts it is refused.
std::vector<SubtreeMesh> subtreeMeshes(const GltfDocument& document, std::size_t root, std::size_t& budget);

}  // namespace tandem::assets
