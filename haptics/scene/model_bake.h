#pragma once

// Bakes the part models of a scene: all of them in parallel, large meshes one after another on all threads
// and small ones side by side, or one.

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "haptics/scene/contact_scene.h"
#include "haptics/scene/part_model.h"

namespace tandem::haptics {

/// What decides, beside a mesh and its tolerance, how fine its field is.
struct BakePlan {
  double smallestHeld = 0.0;  // m, diagonal of the smallest part that a hand can hold: the scene's scale
  std::size_t fields = 0;     // meshes of the scene that get one
  double fieldScale = 1.0;    // ModelOptions
  double sampleScale = 1.0;
  bool coarse = false;  // ModelOptions
};

/// Where the field of one mesh comes from, and who bakes it.
struct BakeHow {
  std::string cacheDirectory;  // empty: nowhere
  bool onlyCached = false;
  int threads = 1;
  std::function<void(double)> progress;     // share done, in the calling thread
  const std::atomic<bool>* stop = nullptr;  // once true, the bake ends early
};

/// The model of one mesh, which is not empty. `tolerance`: m, see partTolerances(). `features`: those of the
/// coarse model that it follows, else null. Null if it was stopped, or not in the cache.
std::shared_ptr<const PartModel> bakeModel(const TriangleBvh& tree, double tolerance, const BakePlan& plan,
                                           const BakeHow& how,
                                           std::shared_ptr<const PartFeatures> features = nullptr);

/// A model for each tree, null for an absent or empty tree; an empty list if `options.progress` stopped.
/// `tolerances`: m, one per tree. `shapes`: the implicit shapes of each tree, which need no bake; empty for a
/// mesh.
std::vector<std::shared_ptr<const PartModel>> bakeModels(
    const std::vector<std::shared_ptr<TriangleBvh>>& trees, const std::vector<double>& tolerances,
    const std::vector<std::vector<assets::ImplicitShape>>& shapes, double smallestHeld,
    const ModelOptions& options);

/// How many of the trees get a field.
std::size_t fieldsOf(const std::vector<std::shared_ptr<TriangleBvh>>& trees,
                     const std::vector<std::vector<assets::ImplicitShape>>& shapes);

}  // namespace tandem::haptics
