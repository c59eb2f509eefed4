#pragma once

// Invariant 3 of scene.h, as code: what unpackScene() demands of bytes from a network, and what tests demand
// of the loader.

#include "assets/base/result.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// Whether every index is in range, every number finite and within what value_ranges.h allows, every position
/// nearer than kMaxCoordinate, every array of its shape, every name printable; an error names the first thing
/// that is not. O(size of the scene).
Status checkScene(const Scene& scene);

}  // namespace tandem::assets
