#pragma once

// What extras.cad states, see assets/cad_import: exact cylinders of faces, tolerances of nodes, and what the
// import had to say of the file. For the loader's sources only.

#include <cstdint>
#include <string>
#include <vector>

#include "assets/gltf/gltf_document.h"
#include "assets/gltf/gltf_geometry.h"
#include "assets/mesh/round_faces.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// Those of all pieces of a part, in its frame. `damaged` grows by the faces that cannot be read, and by
/// those that a piece scales or shears out of round; none of them refuses the file.
RoundFaces readRoundFaces(const GltfDocument& document, const std::vector<MeshPiece>& pieces,
                          std::uint64_t& damaged);

/// The dimensions and tolerances that a node states, in words as they may be shown. What is none is passed
/// over: other programs too may write an extras.cad.
std::vector<std::string> readTolerances(const GltfDocument& document, std::size_t gltfNode);

/// What the import of a CAD file had to say, as warnings of the whole scene. What is none is passed over.
std::vector<Finding> readImportFindings(const GltfDocument& document);

}  // namespace tandem::assets
