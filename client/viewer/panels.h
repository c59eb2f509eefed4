#pragma once

// The panels around the scene. Each draws the model, and writes the person's input into the state of the
// interface or the actions. ImGui's context is current.

#include <memory>
#include <string>

#include "client/marks/hand_glyphs.h"
#include "client/viewer/theme.h"
#include "client/viewer/ui_state.h"

namespace tandem::client {

/// What every panel needs.
struct PanelContext {
  const ViewModel& model;
  UiState& ui;
  ViewActions& actions;
  const Fonts& fonts;
  float scale = 1.0f;
  bool live = true;  // in a window, drawn again and again
};

/// The tree of parts with search; keeps which nodes are open.
class PartTree {
 public:
  explicit PartTree(const assets::Scene& scene);
  void draw(const PanelContext& context);

 private:
  struct Row {
    std::uint32_t node = assets::kNone;
    PartId part = kNoPart;
    int depth = 0;
    bool hasChildren = false;
  };
  void collect(std::uint32_t node, int depth, std::vector<Row>& rows) const;
  void collectMatches(const std::string& needle, std::vector<Row>& rows) const;
  std::vector<PartId> partsUnder(std::uint32_t node) const;
  void drawRow(const PanelContext& context, const Row& row);
  void drawMenu(const PanelContext& context, const Row& row);
  std::string nameOf(const Row& row) const;

  const assets::Scene& scene_;
  std::vector<std::vector<std::uint32_t>> children_;  // a tree node's nodes
  std::vector<std::vector<PartId>> partsOf_;          // a tree node's own parts
  std::vector<std::uint32_t> roots_;
  std::vector<PartId> loose_;  // parts outside the tree
  std::vector<bool> open_;
};

/// Whether a fault keeps force off.
inline bool hasFault(const ViewModel& model) {
  return (model.hand.flags & haptics::kFlagFault) != 0 || !model.hand.fault.empty();
}

/// Side panels and status bar; returns what they leave of the window for the scene.
Rect drawPanels(const PanelContext& context, PartTree& tree, const glm::dvec2& window);

// The sections of the right panel.
void drawPeople(const PanelContext& context);
/// Who shares a view or sections, whether that is followed, and buttons for both.
void drawSharing(const PanelContext& context);
/// What people say, and a line to write in.
void drawChat(const PanelContext& context);
/// The scene's controls with their values; a permitted role may set them.
void drawControls(const PanelContext& context);
/// The list of clashes with the inputs of the search; requests the search when it is drawn for the first
/// time.
void drawClashes(const PanelContext& context);
/// The notes and views of the session's document, and what the person writes.
void drawNotes(const PanelContext& context);
void drawHand(const PanelContext& context);
/// The dimensions and tolerances that the file states of the selected part.
void drawTolerances(const PanelContext& context);
void drawNetwork(const PanelContext& context);
void drawSettings(const PanelContext& context);

// What lies over the scene.
void drawLabels(const View& view, const Rect& viewport, const std::vector<Label>& labels,
                const PanelContext& context);
void drawNotices(const PanelContext& context, const Rect& viewport);
/// The panel of measures, while it is open.
void drawMeasures(const PanelContext& context, const Rect& viewport);
/// Says that parts are drawn elsewhere than they are, while they are.
void drawApart(const PanelContext& context, const Rect& viewport);
void drawReplayBar(const PanelContext& context, const Rect& viewport);
void drawHelp(const PanelContext& context);
/// The range of a slider and the format of its number.
struct SliderRange {
  float min, max;
  const char* pattern;  // of printf, for one double
  int flags = 0;        // ImGuiSliderFlags
};
/// A slider with its number to the right, where the handle does not cover it. True if the person moved it.
/// The section planes: for each axis what is cut away beyond a place, and before one.
void drawSections(const PanelContext& context);
/// The search for a part's way out, and what it found.
void drawWayOut(const PanelContext& context);
/// How far parts are drawn apart, and which.
void drawExplode(const PanelContext& context);
bool numberSlider(const PanelContext& context, const char* id, float& value, const SliderRange& range);
/// The activity of a person in words: holds, touches, watches.
std::string activityOf(const ViewModel& model, const SiteView& site);
/// A filled circle of a site's colour, as tall as a line of text.
void colourDot(const glm::vec3& srgb, bool hollow = false);
/// A text cut to a width, pixels.
std::string shortenedTo(const std::string& text, float width);
/// Menu entries for one part: fit, hide, isolate, transparent, take away.
void partMenu(const PanelContext& context, const std::vector<PartId>& parts);

}  // namespace tandem::client
