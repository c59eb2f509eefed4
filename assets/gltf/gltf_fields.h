#pragma once

// The force fields that a glTF file places: extras.haptic.field of a node (an object, or an array of them)
// and extras.haptic.fields of the scene. The vocabulary stands in assets/scene/README.md. For the loader's
// sources only.

#include <cstdint>
#include <string>
#include <vector>

#include "assets/gltf/gltf_document.h"
#include "assets/gltf/gltf_nodes.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// A field whose frame stands in the world so far: partFromField is worldFromField.
struct PlacedField {
  ForceField field;
  std::uint32_t flatNode = kNone;  // the node that it goes with; kNone: the scene's own
  std::string place;               // in the file, for messages
};

/// All fields of the default scene, in m and SI, each property checked. A file's own lengths are scaled with
/// their node and by `unitScale`; everything else is SI as it stands. Throws GltfError.
std::vector<PlacedField> readFields(const GltfDocument& document, const std::vector<FlatNode>& nodes,
                                    double unitScale);

}  // namespace tandem::assets
