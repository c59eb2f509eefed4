#pragma once

// Bakes the part models of a scene in parallel: large meshes one after another on all threads, small ones
// side by side.

#include <memory>
#include <vector>

#include "haptics/scene/contact_scene.h"
#include "haptics/scene/part_model.h"

namespace tandem::haptics {

/// A model for each tree, null for an absent or empty tree; an empty list if `options.progress` stopped.
/// `tolerances`: m, one per tree, see partTolerances(). `smallestHeld`: m, diagonal of the smallest part that
/// a hand can hold, the length scale of the scene. `shapes`: the implicit shapes of each tree, which need no
/// bake; empty for a mesh.
std::vector<std::shared_ptr<const PartModel>> bakeModels(
    const std::vector<std::shared_ptr<TriangleBvh>>& trees, const std::vector<double>& tolerances,
    const std::vector<std::vector<assets::ImplicitShape>>& shapes, double smallestHeld,
    const ModelOptions& options);

}  // namespace tandem::haptics
