#pragma once

// Names that are similar to a misspelt one.

#include <string>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// "; near it are 'a', 'b'": the names most similar to `wanted`; empty if there are none.
std::string nearNames(const std::string& wanted, const std::vector<std::string>& names);

/// The same for the names of a scene's parts.
std::string nearParts(const std::string& wanted, const Scene& scene);

/// The most similar name if it differs by at most two letters; else empty.
std::string meantName(const std::string& wanted, const std::vector<std::string>& names);

}  // namespace tandem::assets
