#pragma once

// 3MF packages: what is to be built, with its names, places, colours and unit.

#include <string>

#include "assets/base/result.h"
#include "assets/cad_import/cad_scene.h"
#include "assets/cad_import/import_options.h"
#include "assets/cad_import/read_3mf.h"

namespace tandem::cad_import {

/// Objects that are put together become nodes, and a mesh that several of them use is kept once. Supports
/// are left out. What says nothing of what is to be built has all that no object uses.
Result<CadScene> import3mf(const std::string& path, const ImportOptions& options);

/// The same of a package that is read already; `name` is the scene's.
Result<CadScene> sceneOf3mf(ThreeMfPackage package, const std::string& name, const ImportOptions& options);

}  // namespace tandem::cad_import
