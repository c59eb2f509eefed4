#pragma once

// Finds the way of a part out of its assembly in a thread of its own, on one core and at a lower priority
// than the hand's loop. Nothing is moved. Before the first search there is no thread, and no copy of the
// scene.
//
// 1. All methods are for one thread, which never waits in them; only the destructor waits.
// 2. A search that is stopped ends after the pull, or the model, that it is at; its answer is forgotten.

#include <memory>
#include <string>
#include <vector>

#include "client/extraction/part_extraction.h"

namespace tandem::client {

class ExtractionSearch {
 public:
  struct State {
    PartId part = kNoPart;  // whose way out is searched for, or is found; none: of nothing
    bool running = false;
    double done = 0.0;       // 0..1, of what it is doing
    const char* doing = "";  // that, in words
    bool cannot = false;     // no hand can take the part: it is fixed, a control, or without a surface
    std::shared_ptr<const Extraction> found;  // null: not yet
  };

  /// The scene must outlive this and not change. Models of its parts are kept in `cacheDirectory`; empty:
  /// nowhere.
  ExtractionSearch(const assets::Scene& scene, std::string cacheDirectory);
  ~ExtractionSearch();
  ExtractionSearch(const ExtractionSearch&) = delete;
  ExtractionSearch& operator=(const ExtractionSearch&) = delete;

  /// Searches with parts at these poses, one a part.
  void start(PartId part, const std::vector<Pose>& worldFromPart);
  /// Stops, and forgets what was found.
  void clear();
  State state() const;

 private:
  class Worker;
  const assets::Scene& scene_;
  std::string cacheDirectory_;
  std::unique_ptr<Worker> worker_;                // null: nothing is searched for
  std::vector<std::unique_ptr<Worker>> stopped_;  // not ended yet
};

}  // namespace tandem::client
