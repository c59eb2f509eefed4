#pragma once

// What somebody who misspelt a name may have meant.

#include <string>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// "; near it are 'a', 'b'": the names most like `wanted`, or nothing if there are none.
std::string nearNames(const std::string& wanted, const std::vector<std::string>& names);

/// The same of a scene's parts.
std::string nearParts(const std::string& wanted, const Scene& scene);

/// The one name that is at most two letters off, or an empty text.
std::string meantName(const std::string& wanted, const std::vector<std::string>& names);

}  // namespace tandem::assets
