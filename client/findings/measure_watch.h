#pragma once

// Measures the places that a person marked on parts, live while parts move, in a thread of its own: which
// edges and cylinders are there, and how near two parts are. The rest is arithmetic of the calling thread.
//
// 1. All methods are for one thread, which never waits in them; only the destructor waits for a measurement.
// 2. A clearance is measured again when its parts have moved, and takes at most a quarter of a core.

#include <memory>
#include <vector>

#include "client/findings/figures.h"

namespace tandem::client {

/// What is known of the marks.
struct MeasureView {
  bool possible = false;              // places can be marked here
  std::vector<MeasuredPlace> places;  // world, one a mark; empty until they are known
  std::optional<Clash> parts;         // of two marks on different parts, as they stood a moment ago
  std::vector<Figure> figures;
};

class MeasureWatch {
 public:
  /// The geometry must outlive this, and its meshes must not change.
  explicit MeasureWatch(const haptics::ContactScene& contact);
  ~MeasureWatch();
  MeasureWatch(const MeasureWatch&) = delete;
  MeasureWatch& operator=(const MeasureWatch&) = delete;

  /// The figures of at most two marks with the parts at these poses (one a part).
  MeasureView update(const std::vector<document::Anchor>& marks, const std::vector<Pose>& worldFromPart);

 private:
  class Worker;
  const haptics::ContactScene& contact_;
  std::unique_ptr<Worker> worker_;  // null before the first mark
};

}  // namespace tandem::client
