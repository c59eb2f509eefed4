#pragma once

// Finds the clashes of an assembly in a thread of its own, on one core and at a lower priority than the
// hand's loop. Before the first search there is no thread.
//
// 1. All methods are for one thread, which never waits in them; only the destructor waits.

#include <memory>
#include <vector>

#include "client/review/clash_view.h"

namespace tandem::client {

class ClashSearch {
 public:
  /// The geometry must outlive this, and its meshes must not change.
  explicit ClashSearch(const haptics::ContactScene& contact);
  /// Stops, and waits for the pairs that are being measured.
  ~ClashSearch();
  ClashSearch(const ClashSearch&) = delete;
  ClashSearch& operator=(const ClashSearch&) = delete;

  /// Starts a search at these poses (one a part; ignored where the question is of parts at rest). A running
  /// search is stopped and ends after the pair that it is measuring.
  void start(const ClashQuestion& question, const std::vector<Pose>& worldFromPart);
  /// Stops the running search after the pair that it is measuring. Its findings until then are its answer.
  void stop();
  ClashSearchView view() const;

 private:
  class Worker;
  const haptics::ContactScene& contact_;
  std::unique_ptr<Worker> worker_;                // null before the first question
  std::vector<std::unique_ptr<Worker>> stopped_;  // stopped by newer questions, not ended yet
  std::shared_ptr<const ClashFindings> last_;
};

/// Runs such a search in the calling thread. `progress` and `stop` as in ClashOptions.
ClashFindings searchClashes(const haptics::ContactScene& contact, const ClashQuestion& question,
                            const std::vector<Pose>& worldFromPart,
                            const std::function<void(std::size_t, std::size_t)>& progress = {},
                            const std::atomic<bool>* stop = nullptr);

}  // namespace tandem::client
