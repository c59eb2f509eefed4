#pragma once

// Units of length as CAD files and users name them, and whether one makes sense.

#include <optional>
#include <string>

#include "assets/cad_import/cad_scene.h"

namespace tandem::cad_import {

/// m a unit: "m", "cm", "mm", "inch", "foot" as users write them, and "MILLIMETRE", "metre", "INCH", "micron"
/// as files do; nothing for any other name.
std::optional<double> metresPerUnit(const std::string& name);

/// One sentence if the scene is longer than 50 m or shorter than 1 mm as its unit was read, with what another
/// unit would make of it; else empty.
std::string unitDoubt(const CadScene& scene);

}  // namespace tandem::cad_import
