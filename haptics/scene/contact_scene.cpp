#include "haptics/scene/contact_scene.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <thread>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/scene/control.h"
#include "haptics/base/in_parallel.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/implicit_mesh.h"
#include "haptics/scene/model_bake.h"
#include "haptics/scene/part_tolerance.h"
#include "haptics/scene/surface_scene.h"

namespace tandem::haptics {
namespace {

// Meshes above this many triangles are built one after another on all threads, smaller ones in parallel.
constexpr std::size_t kBuiltAlone = 50'000;

/// The skin: the tool stays this far off a surface, so that rounding never puts it on the other side. It is
/// 1e-9 of the part's size plus the rounding of the coordinates where the part lies far from its own origin.
double skinOf(const assets::Bounds& bounds) {
  const glm::dvec3 furthest = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
  return glm::length(bounds.max - bounds.min) * 0x1p-30 + glm::length(furthest) * 0x1p-42;
}

void buildTrees(const std::vector<const assets::Mesh*>& meshes,
                std::vector<std::shared_ptr<TriangleBvh>>& trees, int threads) {
  std::vector<std::size_t> small;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    if (meshes[i] == nullptr) continue;
    if (meshes[i]->triangles.size() > kBuiltAlone) {
      trees[i] = std::make_shared<TriangleBvh>(*meshes[i], threads);
    } else {
      small.push_back(i);
    }
  }
  std::atomic<std::size_t> next{0};
  const int workers = std::clamp(static_cast<int>(small.size()), 1, threads);
  onThreads(workers, [&](int) {
    for (std::size_t i = next++; i < small.size(); i = next++) {
      trees[small[i]] = std::make_shared<TriangleBvh>(*meshes[small[i]], 1);
    }
  });
}

std::size_t bytesOf(const assets::Mesh& mesh) {
  const auto bytes = [](const auto& list) { return list.size() * sizeof(list[0]); };
  return bytes(mesh.positions) + bytes(mesh.triangles) + bytes(mesh.triangleMaterial) +
         bytes(mesh.neighbours) + bytes(mesh.edgeFlags) + bytes(mesh.triangleShell) + bytes(mesh.triangleUv) +
         bytes(mesh.triangleNormal);
}

/// Key of a list of shapes: parts of equal shapes share a tree, like parts of one mesh.
std::vector<double> numbersOf(const std::vector<assets::ImplicitShape>& shapes) {
  std::vector<double> numbers;
  for (const assets::ImplicitShape& shape : shapes) {
    const glm::dvec3& at = shape.partFromShape.position;
    const glm::dquat& turn = shape.partFromShape.orientation;
    numbers.insert(numbers.end(), {static_cast<double>(shape.kind), at.x, at.y, at.z, turn.w, turn.x, turn.y,
                                   turn.z, shape.size.x, shape.size.y, shape.size.z, shape.height,
                                   shape.radiusTop, shape.radiusBottom, static_cast<double>(shape.material)});
  }
  return numbers;
}

/// Bounds infinite planes at the extent of their triangles.
std::vector<assets::ImplicitShape> finite(std::vector<assets::ImplicitShape> shapes, double reach) {
  for (assets::ImplicitShape& shape : shapes) {
    if (shape.kind != assets::ImplicitShape::Kind::plane) continue;
    if (!(shape.size.x > 0.0)) shape.size.x = 2.0 * reach;
    if (!(shape.size.z > 0.0)) shape.size.z = 2.0 * reach;
  }
  return shapes;
}

/// Least radius of a tool that is swept along a part: a share of the coordinates that place its surface,
/// which are those of its mesh and of the part within the scene. It is at most 2^-12 of the part, so that a
/// part far smaller than the scene keeps its detail. A plane without bounds counts as large as the scene.
double leastToolOf(const assets::Scene& scene, const assets::Part& part, const assets::Bounds& bounds,
                   double share) {
  const glm::dvec3 centre = 0.5 * (bounds.min + bounds.max);
  double size = glm::length(bounds.max - bounds.min), away = 0.0;
  if (const glm::dvec3 all = scene.bounds.max - scene.bounds.min; glm::length(all) > 0.0 && all.x >= 0.0) {
    size = std::min(size, glm::length(all));
    away = glm::length(part.worldFromPart.position - 0.5 * (scene.bounds.min + scene.bounds.max));
  }
  return std::min(share * (glm::length(centre) + size + away), 0x1p-12 * size);
}

Collider makeCollider(const assets::Scene& scene, const assets::Part& part, const TriangleBvh* tree,
                      double leastToolShare) {
  if (tree == nullptr || tree->empty()) return {};
  const assets::Bounds& bounds = tree->bounds();
  return {tree, 0.5 * (bounds.min + bounds.max), 0.5 * glm::length(bounds.max - bounds.min), skinOf(bounds),
          leastToolOf(scene, part, bounds, leastToolShare)};
}

}  // namespace

ContactScene::Data::Data() = default;
ContactScene::Data::Data(const Data&) = default;
ContactScene::Data::~Data() = default;

ContactScene::ContactScene(const assets::Scene& scene, int threads, double leastToolShare)
    : data_(std::make_unique<Data>()) {
  data_->scene = &scene;
  data_->leastToolShare = leastToolShare;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const glm::dvec3 size = glm::max(scene.bounds.max - scene.bounds.min, glm::dvec3(0.0));
  const double reach = glm::length(size) > 0.0 ? 10.0 * glm::length(size) : 1.0;

  std::vector<const assets::Mesh*> meshes(scene.meshes.size(), nullptr);
  std::map<std::vector<double>, std::size_t> treeOfShapes;
  std::vector<std::size_t> treeOfPart(scene.parts.size(), assets::kNone);
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    const assets::Part& part = scene.parts[i];
    if (!part.shapes.empty()) {
      const auto [same, isNew] = treeOfShapes.emplace(numbersOf(part.shapes), meshes.size());
      treeOfPart[i] = same->second;
      if (!isNew) continue;
      data_->shapeMeshes.push_back(std::make_shared<assets::Mesh>(meshOfShapes(part.shapes, reach)));
      data_->shapes.resize(meshes.size());
      data_->shapes.push_back(finite(part.shapes, reach));
      meshes.push_back(data_->shapeMeshes.back().get());
    } else if (part.mesh != assets::kNone) {
      ASSERT(part.mesh < scene.meshes.size());
      treeOfPart[i] = part.mesh;
      meshes[part.mesh] = &scene.meshes[part.mesh];
    }
  }
  data_->shapes.resize(meshes.size());
  data_->trees.resize(meshes.size());
  data_->replacements.resize(scene.meshes.size());
  data_->deformed.resize(scene.meshes.size(), false);
  buildTrees(meshes, data_->trees, threads > 0 ? threads : cores);
  for (std::size_t i = 0; i < treeOfPart.size(); ++i) {
    const TriangleBvh* const tree =
        treeOfPart[i] == assets::kNone ? nullptr : data_->trees[treeOfPart[i]].get();
    data_->colliders.push_back(makeCollider(scene, scene.parts[i], tree, leastToolShare));
  }
  data_->surfaces = makeSurfaceScene(scene, data_->colliders);
}

void ContactScene::Data::measure(std::uint32_t mesh) {
  bool shaded = false;
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    const assets::Part& part = scene->parts[i];
    if (!part.shapes.empty() || part.mesh != mesh) continue;
    colliders[i] = makeCollider(*scene, part, trees[mesh].get(), leastToolShare);
    shaded = shaded || surfaces == nullptr || surfaces->parts[i].any ||
             !trees[mesh]->mesh().triangleNormal.empty();
  }
  if (!shaded) return;
  std::set<const TriangleBvh*> moved;
  for (std::size_t i = 0; i < deformed.size(); ++i)
    if (deformed[i]) moved.insert(trees[i].get());
  surfaces = makeSurfaceScene(*scene, colliders, moved);
}

double ContactScene::Data::smallestHeld() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    // A held control moves only along its axis, whatever stands in the way.
    const bool free = scene->parts[i].movable && assets::controlOf(*scene, static_cast<PartId>(i)) == nullptr;
    if (free && colliders[i].radius > 0.0) smallest = std::min(smallest, 2.0 * colliders[i].radius);
  }
  return smallest;
}

std::vector<double> ContactScene::Data::treeTolerances(const std::vector<PartTolerance>& ofParts) const {
  std::map<const TriangleBvh*, double> toleranceOf;
  for (std::size_t i = 0; i < colliders.size(); ++i)
    if (const TriangleBvh* tree = colliders[i].tree; tree != nullptr) {
      const double own = ofParts[i].tolerance;
      const auto [it, isNew] = toleranceOf.emplace(tree, own);
      if (!isNew) it->second = std::min(it->second, own);
    }
  std::vector<double> found;
  for (const auto& tree : trees) {
    const auto it = toleranceOf.find(tree.get());
    found.push_back(it == toleranceOf.end() ? 0.0 : it->second);
  }
  return found;
}

bool ContactScene::modelParts(const ModelOptions& options) {
  ASSERT(data_->models.empty());
  const double smallestHeld = data_->smallestHeld();
  if (!std::isfinite(smallestHeld)) return true;
  data_->tolerances = options.coarse
                          ? tolerancesWithoutClearance(*data_->scene, data_->colliders, smallestHeld)
                          : partTolerances(*data_->scene, data_->colliders, smallestHeld, options.threads);
  data_->models = bakeModels(data_->trees, data_->treeTolerances(data_->tolerances), data_->shapes,
                             smallestHeld, options);
  if (data_->models.empty()) return false;
  std::map<const TriangleBvh*, const PartModel*> modelOf;
  for (std::size_t i = 0; i < data_->trees.size(); ++i)
    modelOf[data_->trees[i].get()] = data_->models[i].get();
  for (Collider& collider : data_->colliders)
    if (collider.tree != nullptr) collider.model = modelOf[collider.tree];
  return true;
}

void ContactScene::refitMesh(std::uint32_t mesh, int threads) {
  ASSERT(mesh < data_->scene->meshes.size() && data_->trees[mesh] != nullptr);
  data_->trees[mesh]->refit(threads);
  data_->deformed[mesh] = true;
  data_->measure(mesh);
  if (!data_->models.empty()) data_->models[mesh] = nullptr;
}

ContactScene ContactScene::withMesh(std::uint32_t mesh, std::shared_ptr<const assets::Mesh> replacement,
                                    int threads) const {
  ASSERT(mesh < data_->scene->meshes.size() && data_->trees[mesh] != nullptr);
  ContactScene next(*this);
  if (!next.data_->models.empty()) next.data_->models[mesh] = nullptr;
  next.data_->deformed[mesh] = false;
  next.data_->trees[mesh] = std::make_shared<TriangleBvh>(*replacement, threads);
  next.data_->replacements[mesh] = std::move(replacement);
  next.data_->measure(mesh);
  return next;
}

ContactScene ContactScene::withModel(std::size_t tree, std::shared_ptr<const PartModel> model) const {
  ASSERT(model != nullptr && tree < data_->models.size() && data_->models[tree] != nullptr);
  ASSERT(model->features == data_->models[tree]->features);
  ContactScene next(*this);
  for (Collider& collider : next.data_->colliders)
    if (collider.model == data_->models[tree].get()) collider.model = model.get();
  next.data_->models[tree] = std::move(model);
  return next;
}

ContactScene::ContactScene(const ContactScene& other) : data_(std::make_unique<Data>(*other.data_)) {}
ContactScene::~ContactScene() = default;
ContactScene::ContactScene(ContactScene&&) noexcept = default;
ContactScene& ContactScene::operator=(ContactScene&&) noexcept = default;

const assets::Scene& ContactScene::scene() const { return *data_->scene; }

std::size_t ContactScene::memory() const {
  std::size_t bytes = 0;
  for (const auto& tree : data_->trees) bytes += tree ? tree->memory() : 0;
  for (const auto& model : data_->models) bytes += model ? model->memory() : 0;
  for (const auto& mesh : data_->shapeMeshes) bytes += bytesOf(*mesh);
  for (const auto& mesh : data_->replacements) bytes += mesh ? bytesOf(*mesh) : 0;
  return bytes;
}

std::size_t ContactScene::memory(std::uint32_t mesh) const {
  ASSERT(mesh < data_->scene->meshes.size());
  const std::size_t tree = data_->trees[mesh] ? data_->trees[mesh]->memory() : 0;
  return tree + (mesh < data_->models.size() && data_->models[mesh] ? data_->models[mesh]->memory() : 0);
}

}  // namespace tandem::haptics
