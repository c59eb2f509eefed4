#include "haptics/scene/model_bake.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

#include <glm/geometric.hpp>

#include "haptics/base/in_parallel.h"
#include "haptics/scene/field_cache.h"
#include "haptics/scene/field_resolution.h"
#include "haptics/scene/part_tolerance.h"

namespace tandem::haptics {
namespace {

// Meshes above this many triangles are baked one after another on all threads, smaller ones in parallel.
constexpr std::size_t kBakedAlone = 50'000;
// The fields of a scene share a budget: each of `n` meshes may have smallest cells of n / kShared of its own
// diagonal, and at most kCoarsestCell of it.
constexpr double kShared = 4096.0, kCoarsestCell = 1.0 / 128.0, kFinestCell = 1.0 / 1024.0;
// Sharp edges closer than this fraction of the diagonal belong to grooves, for which cells shrink.
constexpr double kGroove = 1.0 / 16.0;
// Smallest cells of a coarse field, as a share of the mesh's diagonal.
constexpr double kCoarse = 1.0 / 16.0;
constexpr const char* kWhat = "making parts ready to collide";

double sizeOf(const TriangleBvh& tree) { return glm::length(tree.bounds().max - tree.bounds().min); }

ContactSamples::Options samplingOf(const TriangleBvh& tree, double scale) {
  ContactSamples::Options sampling;
  sampling.spacing = scale * ContactSamples::usualSpacing(tree.mesh());
  return sampling;
}

bool hasField(const std::shared_ptr<TriangleBvh>& tree, const std::vector<assets::ImplicitShape>& shapes) {
  return tree != nullptr && !tree->empty() && shapes.empty();
}

/// The field of a mesh that is as exact as its tolerance asks.
DistanceField::Options fineField(const TriangleBvh& tree, const MeshEdges& edges, double tolerance,
                                 const BakePlan& plan) {
  const double size = sizeOf(tree);
  DistanceField::Options field;
  field.tolerance = usableTolerance(tolerance, size);
  const double finest = std::min(kCoarsestCell, static_cast<double>(plan.fields) / kShared);
  // Edges need cells that are small relative to the smallest part and to grooves; curves need cells that
  // bring them within tolerance.
  const double ofEdges = DistanceField::kCellOfTolerance * usualTolerance(plan.smallestHeld, size),
               ofGrooves = edges.sharpSpacing(kGroove * size) * (kCoarsestCell / kGroove);
  const double cell = std::min({ofEdges, ofGrooves, cellForCurves(tree.mesh(), field.tolerance)});
  field.smallestCell = std::clamp(cell, std::max(kFinestCell, finest) * size, kCoarsestCell * size);
  field.tolerance *= plan.fieldScale;
  field.smallestCell *= plan.fieldScale;
  return field;
}

/// The field of a mesh that is there at once: the triangles are asked wherever it is not exact enough.
DistanceField::Options coarseField(const TriangleBvh& tree, double tolerance) {
  DistanceField::Options field;
  field.tolerance = usableTolerance(tolerance, sizeOf(tree));
  field.smallestCell = kCoarse * sizeOf(tree);
  field.onlyCulls = true;
  return field;
}

class Bake {
 public:
  Bake(const std::vector<std::shared_ptr<TriangleBvh>>& trees, const std::vector<double>& tolerances,
       const std::vector<std::vector<assets::ImplicitShape>>& shapes, double smallestHeld,
       const ModelOptions& options)
      : trees_(trees),
        tolerances_(tolerances),
        shapes_(shapes),
        options_(options),
        plan_{smallestHeld, fieldsOf(trees, shapes), options.fieldScale, options.sampleScale, options.coarse},
        models_(trees.size()) {
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    threads_ = options.threads > 0 ? options.threads : cores;
    for (std::size_t i = 0; i < trees.size(); ++i) {
      if (trees[i] == nullptr || trees[i]->empty()) continue;
      if (!shapes[i].empty()) {
        modelShapes(i);
        continue;
      }
      order_.push_back(i);
      total_ += weight(i);
    }
    // Largest first, so that no long task starts last.
    std::stable_sort(order_.begin(), order_.end(),
                     [this](std::size_t a, std::size_t b) { return weight(a) > weight(b); });
  }

  std::vector<std::shared_ptr<const PartModel>> run() {
    std::size_t first = 0;
    while (first < order_.size() && triangles(order_[first]) > kBakedAlone && !stopped_)
      bake(order_[first++], threads_, true);
    const int small = static_cast<int>(order_.size() - first);
    const int workers = std::clamp(small, 1, threads_), each = std::max(1, threads_ / workers);
    std::atomic<std::size_t> next{first};
    onThreads(workers, [&](int worker) {
      for (std::size_t i = next++; i < order_.size() && !stopped_; i = next++)
        bake(order_[i], each, worker == 0);
    });
    if (stopped_) return {};
    return std::move(models_);
  }

 private:
  std::size_t triangles(std::size_t tree) const { return trees_[tree]->mesh().triangles.size(); }
  /// Approximate cost of a bake; even a box has a surface.
  double weight(std::size_t tree) const { return static_cast<double>(triangles(tree)) + 5e3; }

  void modelShapes(std::size_t i) {
    const auto start = std::chrono::steady_clock::now();
    const TriangleBvh& tree = *trees_[i];
    // The tolerance follows the smallest part, however large this one is: it costs nothing.
    const double tolerance = std::min(usableTolerance(tolerances_[i], sizeOf(tree)),
                                      usualTolerance(plan_.smallestHeld, plan_.smallestHeld));
    auto model =
        std::make_shared<PartModel>(tree, shapes_[i], samplingOf(tree, plan_.sampleScale), tolerance);
    model->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    models_[i] = std::move(model);
  }

  /// Runs in the calling thread of run() only.
  void tell(double within) {
    if (options_.progress && !options_.progress((static_cast<double>(done_) + within) / total_, kWhat))
      stopped_ = true;
  }

  void bake(std::size_t i, int threads, bool telling) {
    if (telling) tell(0.0);
    BakeHow how;
    how.cacheDirectory = options_.cacheDirectory;
    how.onlyCached = options_.onlyCached;
    how.threads = threads;
    how.stop = &stopped_;
    if (telling) how.progress = [this, i](double share) { tell(share * weight(i)); };
    models_[i] = bakeModel(*trees_[i], tolerances_[i], plan_, how);
    done_ += static_cast<std::uint64_t>(weight(i));
    if (telling) tell(0.0);
  }

  const std::vector<std::shared_ptr<TriangleBvh>>& trees_;
  const std::vector<double>& tolerances_;  // m, one per tree
  const std::vector<std::vector<assets::ImplicitShape>>& shapes_;
  const ModelOptions& options_;
  BakePlan plan_;
  int threads_ = 1;
  double total_ = 0.0;
  std::vector<std::size_t> order_;  // indices of trees
  std::vector<std::shared_ptr<const PartModel>> models_;
  std::atomic<std::uint64_t> done_{0};
  std::atomic<bool> stopped_{false};
};

}  // namespace

std::shared_ptr<const PartModel> bakeModel(const TriangleBvh& tree, double tolerance, const BakePlan& plan,
                                           const BakeHow& how, std::shared_ptr<const PartFeatures> features) {
  const auto start = std::chrono::steady_clock::now();
  std::optional<MeshEdges> found;
  const MeshEdges& edges = features != nullptr ? features->edges : found.emplace(tree.mesh());
  DistanceField::Options options =
      plan.coarse ? coarseField(tree, tolerance) : fineField(tree, edges, tolerance, plan);
  options.threads = how.threads;
  options.progress = how.progress;
  options.stop = how.stop;
  bool cached = how.onlyCached;
  std::optional<DistanceField> field;
  if (how.onlyCached)
    field = readField(tree, options, how.cacheDirectory);
  else
    field = cachedField(tree, options, plan.coarse ? std::string() : how.cacheDirectory, cached);
  if (!field || field->stopped()) return nullptr;
  if (features == nullptr)
    features = std::make_shared<PartFeatures>(tree.mesh(), std::move(*found), field->solid(),
                                              samplingOf(tree, plan.sampleScale));
  auto model = std::make_shared<PartModel>(tree, std::move(features), std::move(*field));
  model->coarse = plan.coarse;
  model->cached = cached;
  model->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return model;
}

std::size_t fieldsOf(const std::vector<std::shared_ptr<TriangleBvh>>& trees,
                     const std::vector<std::vector<assets::ImplicitShape>>& shapes) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < trees.size(); ++i) count += hasField(trees[i], shapes[i]) ? 1 : 0;
  return count;
}

std::vector<std::shared_ptr<const PartModel>> bakeModels(
    const std::vector<std::shared_ptr<TriangleBvh>>& trees, const std::vector<double>& tolerances,
    const std::vector<std::vector<assets::ImplicitShape>>& shapes, double smallestHeld,
    const ModelOptions& options) {
  return Bake(trees, tolerances, shapes, smallestHeld, options).run();
}

}  // namespace tandem::haptics
