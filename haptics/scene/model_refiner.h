#pragma once

// Refines the coarse models of a scene while they are felt, in a thread of its own: the mesh nearest to the
// hand first. Contact is as exact with coarse models as with fine ones, because what a field leaves open the
// triangles answer, so a hand feels nothing when a field is exchanged; only ticks become cheaper.

#include <atomic>
#include <cstddef>
#include <deque>
#include <functional>
#include <thread>
#include <vector>

#include "haptics/scene/contact_scene.h"

namespace tandem::haptics {

class ModelRefiner {
 public:
  /// Begins at once. `coarse`: a scene whose models are coarse; without models there is nothing to do. Its
  /// models are freed as the ticks go on to finer ones, unless another scene shares them. `hand`: where the
  /// hand is, m, world, in any thread.
  ModelRefiner(ContactScene coarse, const ModelOptions& options, std::function<glm::dvec3()> hand);
  /// Stops within the time of a few cells. The ticking thread must have ended, or gone on to another scene.
  ~ModelRefiner();
  ModelRefiner(const ModelRefiner&) = delete;
  ModelRefiner& operator=(const ModelRefiner&) = delete;

  /// The scene to go on with, see TickState::refine(); it has all models that are refined so far. What was
  /// returned before may end from here on. For the ticking thread, between ticks: no lock, no allocation.
  const ContactScene& newest() {
    const ContactScene* scene = newest_.load(std::memory_order_acquire);
    inUse_.store(scene, std::memory_order_release);
    return *scene;
  }

  /// Share of the meshes, by cost, that are refined, 0..1. Any thread.
  double done() const { return done_.load(std::memory_order_relaxed); }

 private:
  void run();
  /// Indices of the trees whose models are coarse.
  void findCoarse();
  /// The coarse tree whose parts, where the file has them, are nearest to the hand; there is one.
  std::size_t nearest() const;
  void publish(ContactScene scene);

  ModelOptions options_;
  std::function<glm::dvec3()> hand_;
  // Of the worker.
  std::vector<std::size_t> treeOfPart_;
  std::vector<bool> isCoarse_;       // of each tree
  std::size_t left_ = 0;             // coarse trees
  double weight_ = 0.0;              // of all that were coarse
  std::deque<ContactScene> scenes_;  // oldest first
  std::atomic<const ContactScene*> newest_, inUse_;
  std::atomic<double> done_{0.0};
  std::atomic<bool> stop_{false};
  std::thread worker_;
};

}  // namespace tandem::haptics
