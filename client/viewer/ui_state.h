#pragma once

// The state that the panels change and the viewer reads.

#include <array>
#include <optional>
#include <vector>

#include "client/marks/clash_list.h"
#include "client/marks/measure_list.h"
#include "client/marks/note_list.h"
#include "client/marks/part_display.h"
#include "client/marks/section_set.h"
#include "client/marks/shared_view.h"
#include "client/marks/verdict_list.h"

namespace tandem::client {

struct UiState {
  explicit UiState(std::size_t partCount) : parts(partCount) {}

  PartDisplay parts;
  ClashUi clashes;
  ClashListing clashListing;
  NoteUi notes;
  MeasureUi measures;
  SectionSet sections;
  SharedView shared;
  ChatUi chat;
  bool showPanels = true;
  bool showHelp = false;
  bool showEdges = true;
  bool followSurface = true;
  SiteId following = kNoSite;              // whose camera this one follows
  std::optional<std::vector<PartId>> fit;  // parts to fit the view to in this frame; empty = all visible ones
  bool fitFlies = false;                   // the camera flies there
  std::array<char, 128> search{};
};

/// A rectangle in window pixels.
struct Rect {
  glm::dvec2 min{0.0, 0.0}, max{1.0, 1.0};
  glm::dvec2 size() const { return max - min; }
  bool contains(const glm::dvec2& p) const {
    return p.x >= min.x && p.y >= min.y && p.x < max.x && p.y < max.y;
  }
};

}  // namespace tandem::client
