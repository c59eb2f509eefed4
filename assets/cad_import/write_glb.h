#pragma once

// A scene as binary glTF.

#include <string>

#include "assets/cad_import/cad_scene.h"

namespace tandem::cad_import {

/// The bytes of a .glb file: the same scene gives the same bytes. The exact faces of a mesh stand in its
/// `extras.cad.faces`; material, density and tolerances of a node in its `extras.cad`; what a user should
/// know about the file in `asset.extras.cad.findings`.
std::string toGlb(const CadScene& scene);

}  // namespace tandem::cad_import
