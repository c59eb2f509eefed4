#pragma once

// Controls from extras.haptic.control of nodes. For the loader's sources only.

#include <vector>

#include "assets/gltf/gltf_document.h"
#include "assets/gltf/gltf_nodes.h"
#include "assets/scene/control.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// The controls that the nodes state. `scene` holds the parts and joints already; `partOfNode[i]` is the part
/// whose own node is nodes[i], else kNoPart. The file's lengths are in units of `unitScale` m. Throws
/// GltfError.
///
/// If a joint with one free axis connects the part to something fixed, that joint gives the axis, the rest
/// value and, where the control states none, the stops. Otherwise `axis` and `origin` in the node's frame
/// give the axis.
std::vector<Control> readControls(const GltfDocument& document, const Scene& scene,
                                  const std::vector<FlatNode>& nodes, const std::vector<PartId>& partOfNode,
                                  double unitScale);

}  // namespace tandem::assets
