#pragma once

// What an import tells: as JSON, and in words.

#include <string>

#include "assets/base/json.h"
#include "assets/cad_import/cad_scene.h"
#include "assets/cad_import/import_file.h"

namespace tandem::cad_import {

/// {"parts", "meshes", "triangles", "unit", "fits", "exact_faces": {kind: count}, "reading_s", "meshing_s",
/// "tolerances": [{"part", "said"}], "findings": [{"code", "count", "message"}]}.
Json reportOf(const CadScene& scene, const ImportFigures& figures);

/// The report as lines for a person; `output` is the file that was written.
std::string inWords(const Json& report, const std::string& output);

}  // namespace tandem::cad_import
