#include "client/levels/level_maker.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"
#include "assets/base/thread_priority.h"

namespace tandem::client {
namespace {}  // namespace

LevelMaker::LevelMaker(const assets::Scene& scene, std::span<const Source> meshes, std::string cacheDirectory,
                       unsigned threads)
    : scene_(scene),
      cacheDirectory_(std::move(cacheDirectory)),
      urgency_(scene.meshes.size(), 0.0f),
      levelsWanted_(meshes.begin(), meshes.end()),
      left_(meshes.size()) {
  const unsigned cores = std::thread::hardware_concurrency();
  if (threads == 0) threads = cores > 3 ? cores - 2 : 1;
  for (unsigned i = 0; i < threads; ++i) workers_.emplace_back([this] { run(); });
}

LevelMaker::~LevelMaker() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void LevelMaker::begin() {
  {
    const std::lock_guard lock(mutex_);
    begun_ = true;
  }
  wake_.notify_all();
}

void LevelMaker::setUrgency(std::uint32_t mesh, float pixels) {
  const std::lock_guard lock(mutex_);
  ASSERT(mesh < urgency_.size());
  urgency_[mesh] = pixels;
}

void LevelMaker::askExact(std::uint32_t mesh) {
  {
    const std::lock_guard lock(mutex_);
    ASSERT(mesh < urgency_.size());
    if (std::find(exactWanted_.begin(), exactWanted_.end(), mesh) != exactWanted_.end()) return;
    exactWanted_.push_back(mesh);
  }
  wake_.notify_one();
}

std::optional<LevelMaker::Made> LevelMaker::take() {
  const std::lock_guard lock(mutex_);
  if (results_.empty()) return std::nullopt;
  Made made = std::move(results_.front());
  results_.pop_front();
  return made;
}

void LevelMaker::run() {
  lowerThreadPriority();
  while (const std::optional<Order> order = next()) work(*order);
}

std::optional<LevelMaker::Order> LevelMaker::next() {
  std::unique_lock lock(mutex_);
  wake_.wait(lock, [&] { return stop_ || (begun_ && (!levelsWanted_.empty() || !exactWanted_.empty())); });
  if (stop_) return std::nullopt;
  // An exact mesh is quickly made, and somebody looks at it.
  if (!exactWanted_.empty()) {
    const Order order{{exactWanted_.front(), {}}, true};
    exactWanted_.erase(exactWanted_.begin());
    return order;
  }
  const auto most =
      std::max_element(levelsWanted_.begin(), levelsWanted_.end(),
                       [&](const Source& a, const Source& b) { return urgency_[a.mesh] < urgency_[b.mesh]; });
  const Order order{*most, false};
  levelsWanted_.erase(most);
  return order;
}

void LevelMaker::work(const Order& order) {
  const auto& [index, content] = order.source;
  const assets::Mesh& mesh = scene_.meshes[index];
  Made made;
  made.mesh = index;
  made.exact = order.exact;
  if (order.exact) {
    made.levels.push_back({makeRenderMesh(mesh), 0.0});
  } else {
    std::optional<std::vector<Level>> kept = readLevels(cacheDirectory_, content);
    if (kept) {
      made.levels = std::move(*kept);
    } else {
      made.levels = makeLevels(mesh, [this] { return stop_.load(); });
      if (stop_) return;
      keepLevels(cacheDirectory_, content, made.levels);
      made_.fetch_add(1, std::memory_order_relaxed);
    }
    left_.fetch_sub(1, std::memory_order_relaxed);
  }
  const std::lock_guard lock(mutex_);
  results_.push_back(std::move(made));
}

}  // namespace tandem::client
