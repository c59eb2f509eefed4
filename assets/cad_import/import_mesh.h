#pragma once

// STL, OBJ and PLY files as a scene of one part, by OpenMesh's readers.

#include <string>

#include "assets/base/result.h"
#include "assets/cad_import/cad_scene.h"
#include "assets/cad_import/import_options.h"

namespace tandem::cad_import {

/// Faces with more corners are cut into triangles; what has no area is left out. The part has the file's
/// name.
Result<CadScene> importMesh(const std::string& path, const ImportOptions& options);

}  // namespace tandem::cad_import
