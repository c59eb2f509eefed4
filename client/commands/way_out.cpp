#include "client/commands/way_out.h"

#include <cmath>
#include <cstdio>

#include "client/base/readable.h"

namespace tandem::client {

namespace {

constexpr double kSlight = 1e-3;  // N

/// A direction in words where it is an axis of the world: "+y"; else its components.
std::string axisInWords(const glm::dvec3& axis) {
  for (int i = 0; i < 3; ++i)
    if (std::abs(axis[i]) > 0.9999) return std::string(axis[i] > 0.0 ? "+" : "-") + "xyz"[i];
  char text[64];
  std::snprintf(text, sizeof text, "(%.2f, %.2f, %.2f)", axis.x, axis.y, axis.z);
  return text;
}

std::string wayInWords(const Extraction& extraction) {
  std::string text;
  for (const ExtractionLeg& leg : extraction.way)
    text +=
        (text.empty() ? "" : ", then ") + readableLength(leg.distance) + " along " + axisInWords(leg.axis);
  return text;
}

}  // namespace

std::string partNamesInWords(const assets::Scene& scene, const std::vector<PartId>& parts) {
  std::string text;
  for (const PartId part : parts) text += (text.empty() ? "" : ", ") + scene.parts[part].name;
  return text;
}

std::string outcomeInWords(const assets::Scene& scene, const Extraction& extraction) {
  if (extraction.free && extraction.way.front().distance == 0.0) return "stands free";
  if (extraction.free) {
    const std::string way = "comes out: " + wayInWords(extraction);
    if (extraction.force < kSlight) return way + ", without resistance";
    char work[32];
    std::snprintf(work, sizeof work, "%.2g", extraction.work);
    return way + "; at most " + threeDigits(extraction.force) + " N, " + work + " J";
  }
  const std::string blockers = partNamesInWords(scene, extraction.blockedBy);
  return "does not come out" + (extraction.way.empty() ? "" : ": furthest " + wayInWords(extraction)) +
         "; blocked by " + (blockers.empty() ? "no part's surface: a joint holds it" : blockers);
}

void WayOut::act(const ViewActions& actions, const std::vector<Pose>& worldFromPart) {
  if (actions.clearWayOut) search_.clear();
  if (actions.findWayOut != kNoPart) search_.start(actions.findWayOut, worldFromPart);
}

WayOutView WayOut::view() const {
  const ExtractionSearch::State state = search_.state();
  WayOutView view;
  view.possible = true;
  view.part = state.part;
  view.running = state.running;
  view.done = state.done;
  view.words = state.doing;
  if (state.cannot)
    view.words = "cannot be taken: it is fixed, a control, or has no surface that others touch";
  if (state.found == nullptr) return view;
  view.words = outcomeInWords(scene_, *state.found);
  view.free = state.found->free;
  view.path = state.found->path;
  view.blockedBy = state.found->blockedBy;
  return view;
}

}  // namespace tandem::client
