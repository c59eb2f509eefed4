#include "client/review/clash_search.h"

#include <algorithm>
#include <mutex>
#include <thread>

#include "assets/base/assert.h"
#include "assets/base/thread_priority.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::client {

namespace {

std::vector<Pose> posesAtRest(const haptics::ContactScene& contact) {
  std::vector<Pose> poses;
  for (const assets::Part& part : contact.scene().parts) poses.push_back(part.worldFromPart);
  return poses;
}

bool overlapAtRest(const PartClosings& closings, const Clash& clash) {
  const std::vector<assets::Part>& parts = closings.contact().scene().parts;
  const std::optional<Clash> there =
      measurePair(closings, clash.a, parts[clash.a].worldFromPart, clash.b, parts[clash.b].worldFromPart);
  return there && there->kind == ClashKind::hard;
}

bool standsAtRest(const haptics::ContactScene& contact, const std::vector<Pose>& poses, PartId part) {
  const Pose& rest = contact.scene().parts[part].worldFromPart;
  return poses[part].position == rest.position && poses[part].orientation == rest.orientation;
}

}  // namespace

ClashFindings searchClashes(const haptics::ContactScene& contact, const ClashQuestion& question,
                            const std::vector<Pose>& worldFromPart,
                            const std::function<void(std::size_t, std::size_t)>& progress,
                            const std::atomic<bool>* stop) {
  ClashFindings findings;
  findings.asked = question;
  findings.worldFromPart = question.atRest ? posesAtRest(contact) : worldFromPart;
  ClashOptions options;
  options.clearance = question.clearance;
  options.threads = 1;
  options.worldFromPart = findings.worldFromPart;
  options.progress = progress;
  options.stop = stop;
  const ClashReport report = findClashes(contact, options);
  findings.pairs = report.pairs;
  findings.complete = report.complete;
  const PartClosings closings(contact);
  for (const Clash& clash : report.clashes) {
    FoundClash& found = findings.found.emplace_back(FoundClash{clash});
    if (stop != nullptr && *stop) findings.complete = false;
    if (clash.kind != ClashKind::hard || !findings.complete) continue;
    found.overlapsAtRest = (standsAtRest(contact, findings.worldFromPart, clash.a) &&
                            standsAtRest(contact, findings.worldFromPart, clash.b)) ||
                           overlapAtRest(closings, clash);
  }
  std::stable_partition(findings.found.begin(), findings.found.end(), [](const FoundClash& f) {
    return f.clash.mayCollide && f.clash.kind == ClashKind::hard && !f.overlapsAtRest;
  });
  return findings;
}

/// One search.
class ClashSearch::Worker {
 public:
  Worker(const haptics::ContactScene& contact, const ClashQuestion& question, std::vector<Pose> poses)
      : thread_([this, &contact, question, poses = std::move(poses)] { run(contact, question, poses); }) {}
  ~Worker() {
    stop();
    thread_.join();
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void stop() { stop_ = true; }

  ClashSearchView view() const {
    const std::lock_guard lock(mutex_);
    return {true, findings_ == nullptr, done_, pairs_, findings_};
  }

 private:
  void run(const haptics::ContactScene& contact, const ClashQuestion& question,
           const std::vector<Pose>& poses) {
    lowerThreadPriority();
    auto findings = std::make_shared<const ClashFindings>(searchClashes(
        contact, question, poses,
        [this](std::size_t done, std::size_t pairs) {
          const std::lock_guard lock(mutex_);
          done_ = done;
          pairs_ = pairs;
        },
        &stop_));
    const std::lock_guard lock(mutex_);
    findings_ = std::move(findings);
  }

  mutable std::mutex mutex_;
  std::atomic<bool> stop_{false};
  std::size_t done_ = 0, pairs_ = 0;
  std::shared_ptr<const ClashFindings> findings_;
  std::thread thread_;  // last member, since it uses all of the above
};

ClashSearch::ClashSearch(const haptics::ContactScene& contact) : contact_(contact) {}
ClashSearch::~ClashSearch() = default;

void ClashSearch::start(const ClashQuestion& question, const std::vector<Pose>& worldFromPart) {
  ASSERT(question.atRest || worldFromPart.size() == contact_.scene().parts.size());
  std::erase_if(stopped_, [](const std::unique_ptr<Worker>& worker) { return !worker->view().running; });
  if (worker_ && worker_->view().running) {
    worker_->stop();
    stopped_.push_back(std::move(worker_));
  } else if (worker_) {
    last_ = worker_->view().findings;
  }
  worker_ = std::make_unique<Worker>(contact_, question, worldFromPart);
}

void ClashSearch::stop() {
  if (worker_) worker_->stop();
}

ClashSearchView ClashSearch::view() const {
  ClashSearchView view;
  if (worker_) view = worker_->view();
  view.possible = true;
  if (view.running) view.findings = last_;
  return view;
}

}  // namespace tandem::client
