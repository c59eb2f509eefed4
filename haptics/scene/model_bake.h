#pragma once

// The part models of a scene, made in parallel: large meshes one after the other on all threads, small ones
// side by side.

#include <memory>
#include <vector>

#include "haptics/scene/contact_scene.h"
#include "haptics/scene/part_model.h"

namespace tandem::haptics {

/// A model for each tree, null where there is no tree or nothing in it; none at all if `options.progress`
/// stopped it. `tolerances`: m, one a tree, see partTolerances(). `held`: m, diagonal of the smallest part that a
/// hand can hold, which says what is small in the scene. `shapes`: what a tree stands for, one a tree; empty for a
/// mesh. Of shapes nothing is baked.
std::vector<std::shared_ptr<const PartModel>> bakeModels(
    const std::vector<std::shared_ptr<TriangleBvh>>& trees, const std::vector<double>& tolerances,
    const std::vector<std::vector<assets::ImplicitShape>>& shapes, double held, const ModelOptions& options);

}  // namespace tandem::haptics
