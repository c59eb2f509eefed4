#pragma once

// Controls from extras.haptic.control of nodes. For the loader's sources only.

#include <vector>

#include "assets/gltf/gltf_document.h"
#include "assets/gltf/gltf_nodes.h"
#include "assets/scene/control.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// The controls that the nodes state. `scene` has its parts and joints; `partOfNode[i]` is the part whose own
/// node is nodes[i], else kNoPart. Lengths of the file are in units of `unitScale` m. Throws GltfError.
///
/// The axis is that of a joint of the part with one free axis and something fixed at its other end, if there
/// is such a joint, else `axis` and `origin` in the node's frame. With a joint the rest value and, where the
/// control states none, the stops are the joint's.
std::vector<Control> readControls(const GltfDocument& document, const Scene& scene,
                                  const std::vector<FlatNode>& nodes, const std::vector<PartId>& partOfNode,
                                  double unitScale);

}  // namespace tandem::assets
