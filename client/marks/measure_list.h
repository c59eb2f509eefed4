#pragma once

// Measuring apart from how its panel is drawn: the places that a person marked, the measures that the
// session's document keeps, and what of both is drawn in the scene.

#include <string>
#include <vector>

#include "client/marks/hand_glyphs.h"
#include "client/picture/glyphs.h"

namespace tandem::client {

/// What the person marked and chose.
struct MeasureUi {
  bool open = false;                    // the panel is shown, and measures are drawn
  std::vector<document::Anchor> marks;  // at most two
  document::EntryId chosen = 0;         // a kept measure; 0: none
};

/// Marks a place of the world on a part; after two, the first of the next.
void markPlace(MeasureUi& ui, const ViewModel& model, PartId part, const glm::dvec3& world);
/// Opens the panel and marks the place under the cursor, or where the tool touches a part; without either,
/// takes the marks away, then closes the panel.
void measureKey(MeasureUi& ui, const ViewModel& model, PartId underCursor, const glm::dvec3& world);
/// Takes the marks away; without any, closes the panel.
void clearMeasure(MeasureUi& ui);
/// Chooses a kept measure: its places are marked, so that it is measured again, live.
void chooseMeasure(MeasureUi& ui, const document::Entry& entry, std::size_t partCount);

/// The kept measures, the newest first. Points into the document.
std::vector<const document::Entry*> measureRows(const document::Document& document);
/// The ends of a measure's line in the world; empty if the scene lacks a part.
std::vector<glm::dvec3> lineOf(const document::Measure& measure, const ViewModel& model);
/// A figure as an entry of the document.
DocumentWish keepFigure(const Figure& figure, const ViewModel& model);

/// A place in words as a note at it.
DocumentWish notePlace(const MeasuredPlace& place, const ViewModel& model);

/// Adds marks, the figures between them, and the kept measures with their values.
void addMeasures(const ViewModel& model, const MeasureUi& ui, GlyphBatch& batch, std::vector<Label>& labels);

}  // namespace tandem::client
