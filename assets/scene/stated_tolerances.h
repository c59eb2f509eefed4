#pragma once

// Dimensions and tolerances that a scene's file states of its parts, as words: findings with a code of their
// own.

#include <string>
#include <vector>

#include "assets/base/ids.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// The code of a finding whose message is "diameter 12 mm +0.018 -0", of the part or group `where`.
inline constexpr const char* kStatedTolerance = "stated-tolerance";

/// What is stated of a part, then with their names of the groups that it belongs to.
std::vector<std::string> statedTolerances(const Scene& scene, PartId part);

}  // namespace tandem::assets
