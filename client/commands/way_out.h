#pragma once

// A part's way out of its assembly in words, and the search for it beside a window.

#include <memory>
#include <string>
#include <vector>

#include "client/extraction/extraction_search.h"
#include "client/session/view_model.h"

namespace tandem::client {

/// "comes out: 0.12 m along +y; at most 3 N, 0.2 J", or what is in the way; after the name of the part.
std::string outcomeInWords(const assets::Scene& scene, const Extraction& extraction);
/// "cap, ring"
std::string partNamesInWords(const assets::Scene& scene, const std::vector<PartId>& parts);

/// The search of a window. Main thread.
class WayOut {
 public:
  /// The scene must outlive this.
  WayOut(const assets::Scene& scene, std::string cacheDirectory)
      : scene_(scene), search_(scene, std::move(cacheDirectory)) {}

  /// Does what the person asked for, with parts at these poses.
  void act(const ViewActions& actions, const std::vector<Pose>& worldFromPart);
  WayOutView view() const;

 private:
  const assets::Scene& scene_;
  ExtractionSearch search_;
};

}  // namespace tandem::client
