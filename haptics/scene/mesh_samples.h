#pragma once

// Contact samples of a mesh.

#include "haptics/scene/contact_samples.h"

namespace tandem::haptics {

/// Samples of the sharp convex edges (which turn by more than `sharp` rad) at `spacing` m, of the corners
/// between them, and of smooth convex surfaces at `smoothSpacing` m.
SampleSet sampleMesh(const assets::Mesh& mesh, const MeshEdges& edges, double spacing, double smoothSpacing,
                     double sharp);

}  // namespace tandem::haptics
