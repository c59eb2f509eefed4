#pragma once

// Looks for the clashes of an assembly in a thread of its own: never in the tick, and on one core, with less claim to it
// than the hand's loop has. Without a question there is no thread.
//
// 1. All methods are for one thread, which never waits in them; the destructor does.

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

  /// Asks anew, of parts at these poses (one a part; not looked at where the question is of parts at rest). A search
  /// that runs is stopped, and ends by itself after the pair that it is measuring.
  void start(const ClashQuestion& question, const std::vector<Pose>& worldFromPart);
  /// The running search ends after the pair that it is measuring; what it has found until then is its answer.
  void stop();
  ClashSearchView view() const;

 private:
  class Worker;
  const haptics::ContactScene& contact_;
  std::unique_ptr<Worker> worker_;                // null before the first question
  std::vector<std::unique_ptr<Worker>> stopped_;  // by newer questions, not ended yet
  std::shared_ptr<const ClashFindings> last_;
};

/// What such a search finds, in the calling thread. `progress` and `stop` as in ClashOptions.
ClashFindings searchClashes(const haptics::ContactScene& contact, const ClashQuestion& question,
                            const std::vector<Pose>& worldFromPart,
                            const std::function<void(std::size_t, std::size_t)>& progress = {},
                            const std::atomic<bool>* stop = nullptr);

}  // namespace tandem::client
