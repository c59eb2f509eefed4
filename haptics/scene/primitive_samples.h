#pragma once

// Contact samples of implicit shapes: edges and corners of boxes and planes as of a mesh, and patches on
// round surfaces, a few hundred a shape. The contact point within a patch is found exactly
// (haptics/touch/patch_touch.h), so the number of patches limits how many places of a round surface touch
// at once, not the accuracy.

#include <span>

#include "haptics/scene/contact_samples.h"

namespace tandem::haptics {

/// Samples of the visible surface of `shapes`, without what they cover of each other. `mesh` is the one that
/// represents the shapes elsewhere; `spacing` (m) is that of samples along a straight edge.
SampleSet sampleShapes(std::span<const assets::ImplicitShape> shapes, const assets::Mesh& mesh,
                       double spacing);

}  // namespace tandem::haptics
