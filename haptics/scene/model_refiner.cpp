#include "haptics/scene/model_refiner.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/thread_priority.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/model_bake.h"
#include "haptics/scene/part_tolerance.h"

namespace tandem::haptics {
namespace {

double weightOf(const TriangleBvh& tree) { return 5e3 + static_cast<double>(tree.mesh().triangles.size()); }

}  // namespace

ModelRefiner::ModelRefiner(ContactScene coarse, const ModelOptions& options,
                           std::function<glm::dvec3()> hand)
    : options_(options), hand_(std::move(hand)) {
  options_.coarse = false;
  scenes_.push_back(std::move(coarse));
  newest_ = inUse_ = &scenes_.back();
  const std::vector<std::shared_ptr<const PartModel>>& models = scenes_.back().data().models;
  const bool any = std::any_of(models.begin(), models.end(),
                               [](const auto& model) { return model != nullptr && model->coarse; });
  if (any)
    worker_ = std::thread([this] { run(); });
  else
    done_ = 1.0;
}

ModelRefiner::~ModelRefiner() {
  stop_ = true;
  if (worker_.joinable()) worker_.join();
}

void ModelRefiner::run() {
  lowerThreadPriority();
  const ContactScene::Data& first = scenes_.back().data();
  const std::vector<double> tolerances =
      first.treeTolerances(partTolerances(*first.scene, first.colliders, first.smallestHeld(),
                                          options_.threads));
  findCoarse();
  double refined = 0.0;
  const BakePlan plan{first.smallestHeld(), fieldsOf(first.trees, first.shapes), options_.fieldScale,
                      options_.sampleScale, false};
  BakeHow how;
  how.cacheDirectory = options_.cacheDirectory;
  how.threads = options_.threads > 0 ? options_.threads
                                     : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  how.stop = &stop_;
  while (left_ > 0 && !stop_) {
    const std::size_t tree = nearest();
    const ContactScene::Data& data = scenes_.back().data();
    refined += weightOf(*data.trees[tree]);
    std::shared_ptr<const PartModel> model =
        bakeModel(*data.trees[tree], tolerances[tree], plan, how, data.models[tree]->features);
    if (model == nullptr) return;
    publish(scenes_.back().withModel(tree, std::move(model)));
    isCoarse_[tree] = false;
    --left_;
    done_ = left_ == 0 ? 1.0 : refined / weight_;
  }
}

void ModelRefiner::findCoarse() {
  const ContactScene::Data& data = scenes_.back().data();
  std::map<const TriangleBvh*, std::size_t> indexOf;
  for (std::size_t i = 0; i < data.models.size(); ++i) {
    isCoarse_.push_back(data.models[i] != nullptr && data.models[i]->coarse);
    if (!isCoarse_.back()) continue;
    indexOf[data.trees[i].get()] = i;
    weight_ += weightOf(*data.trees[i]);
    ++left_;
  }
  for (const Collider& collider : data.colliders) {
    const auto found = indexOf.find(collider.tree);
    treeOfPart_.push_back(found == indexOf.end() ? assets::kNone : found->second);
  }
}

std::size_t ModelRefiner::nearest() const {
  const ContactScene::Data& data = scenes_.back().data();
  const glm::dvec3 at = hand_();
  std::size_t best = assets::kNone;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < data.colliders.size(); ++i) {
    if (treeOfPart_[i] == assets::kNone || !isCoarse_[treeOfPart_[i]]) continue;
    const Collider& collider = data.colliders[i];
    const glm::dvec3 centre = transformPoint(data.scene->parts[i].worldFromPart, collider.centre);
    const double away = glm::distance(centre, at) - collider.radius;
    if (best != assets::kNone && !(away < least)) continue;
    least = away;
    best = treeOfPart_[i];
  }
  ASSERT(best != assets::kNone);
  return best;
}

void ModelRefiner::publish(ContactScene scene) {
  scenes_.push_back(std::move(scene));
  newest_.store(&scenes_.back(), std::memory_order_release);
  // The ticking thread uses one scene, and may take any later one.
  const ContactScene* used = inUse_.load(std::memory_order_acquire);
  while (used != &scenes_.front()) scenes_.pop_front();
}

}  // namespace tandem::haptics
