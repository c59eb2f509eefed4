#include "client/extraction/extraction_search.h"

#include <atomic>
#include <mutex>
#include <thread>
#include <utility>

#include "assets/base/assert.h"
#include "assets/base/thread_priority.h"

namespace tandem::client {

class ExtractionSearch::Worker {
 public:
  Worker(const assets::Scene& scene, std::string cacheDirectory, PartId part, std::vector<Pose> worldFromPart)
      : scene_(scene), cacheDirectory_(std::move(cacheDirectory)), worldFromPart_(std::move(worldFromPart)) {
    state_.part = part;
    state_.running = true;
    state_.doing = "making parts ready to collide";
    thread_ = std::thread([this] { run(); });
  }
  ~Worker() {
    stop();
    thread_.join();
  }
  void stop() { stop_ = true; }
  State state() const {
    const std::lock_guard lock(mutex_);
    return state_;
  }

 private:
  void run() {
    lowerThreadPriority();
    std::shared_ptr<const Extraction> found = search();
    const std::lock_guard lock(mutex_);
    state_.found = std::move(found);
    state_.running = false;
  }

  bool note(double done, const char* doing) {
    const std::lock_guard lock(mutex_);
    state_.done = done;
    state_.doing = doing;
    return !stop_;
  }

  std::shared_ptr<const Extraction> search() {
    ExtractionOptions options;
    options.goesOn = [this](double done) { return note(done, "trying ways out"); };
    assets::Scene scene = scene_;  // of which parts are made light
    for (std::size_t p = 0; p < scene.parts.size(); ++p) scene.parts[p].worldFromPart = worldFromPart_[p];
    lightenParts(scene, options);
    haptics::ContactScene contact(scene, 1);
    haptics::ModelOptions models;
    models.cacheDirectory = cacheDirectory_;
    models.threads = 1;
    models.progress = [this](double done, const char*) {
      return note(done, "making parts ready to collide");
    };
    if (!contact.modelParts(models)) return nullptr;
    const PartExtractor extractor(contact, options);
    const PartId part = state().part;
    if (extractor.canTake(part)) return std::make_shared<const Extraction>(extractor.extract(part));
    const std::lock_guard lock(mutex_);
    state_.cannot = true;
    return nullptr;
  }

  const assets::Scene& scene_;
  const std::string cacheDirectory_;
  const std::vector<Pose> worldFromPart_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  State state_;
  std::thread thread_;
};

ExtractionSearch::ExtractionSearch(const assets::Scene& scene, std::string cacheDirectory)
    : scene_(scene), cacheDirectory_(std::move(cacheDirectory)) {}

ExtractionSearch::~ExtractionSearch() {
  clear();  // all at once, before each is waited for
}

void ExtractionSearch::start(PartId part, const std::vector<Pose>& worldFromPart) {
  ASSERT(part < scene_.parts.size() && worldFromPart.size() == scene_.parts.size());
  clear();
  worker_ = std::make_unique<Worker>(scene_, cacheDirectory_, part, worldFromPart);
}

void ExtractionSearch::clear() {
  std::erase_if(stopped_, [](const std::unique_ptr<Worker>& worker) { return !worker->state().running; });
  if (worker_ == nullptr) return;
  worker_->stop();
  stopped_.push_back(std::move(worker_));
}

ExtractionSearch::State ExtractionSearch::state() const {
  return worker_ != nullptr ? worker_->state() : State{};
}

}  // namespace tandem::client
