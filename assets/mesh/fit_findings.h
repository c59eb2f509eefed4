#pragma once

// Finds fits that a file's triangles cannot represent: shafts in bores of other parts whose play is smaller
// than the error of their flat facets.

#include <vector>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// A warning "coarse-fit" for each pair of meshes in which a shaft and a bore are coaxial, one of the
/// two is movable, and facets deviate from the circle by more than half of the radial clearance. Of diametral
/// clearance c and radius r that takes at least pi / sqrt(c / 2r) segments. O(triangles), and the pairs of
/// shafts and bores of about the same radius.
std::vector<Finding> fitFindings(const Scene& scene);

}  // namespace tandem::assets
