#pragma once

// Size of a scene, and whether it suggests a wrong unit.

#include <string>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// "0.68 x 0.3 x 0.2 m": the sides of the box around all parts at rest, three digits each.
std::string sizeInWords(const Scene& scene);

/// One sentence about a scene longer than 50 m, or else about the heaviest part that can be taken if it is
/// heavier than 10 t: few assemblies are, but every file in millimetres that is read as metres is. Else
/// empty. `units`: what --units said.
std::string unitDoubt(const Scene& scene, const std::string& units);

}  // namespace tandem::assets
