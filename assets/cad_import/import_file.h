#pragma once

// The door: a CAD file of any format that is read, told by the end of its name.

#include <cstddef>
#include <string>

#include "assets/base/result.h"
#include "assets/cad_import/cad_scene.h"
#include "assets/cad_import/import_options.h"
#include "assets/cad_import/import_step.h"

namespace tandem::cad_import {

using ImportFigures = StepFigures;

/// The scene, or the reason why there is none, without the file's name.
Result<CadScene> importFile(const std::string& path, const ImportOptions& options, ImportFigures& figures);

}  // namespace tandem::cad_import
