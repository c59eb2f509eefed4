#pragma once

// Finds fits that a file's triangles cannot represent: shafts in bores of other parts whose play is smaller
// than the error of their flat facets.

#include <vector>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// A warning "coarse-fit" for each pair of meshes of which a shaft and a bore stand in one line, one of the
/// two can be moved, and facets lie off the round by more than half of their radial clearance. Of diametral
/// clearance c and radius r that takes at least pi / sqrt(c / 2r) segments. O(triangles), and the pairs of
/// shafts and bores of about the same radius.
std::vector<Finding> fitFindings(const Scene& scene);

}  // namespace tandem::assets
