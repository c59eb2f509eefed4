#include "client/marks/measure_list.h"

#include <algorithm>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/printable.h"
#include "client/marks/note_list.h"
#include "client/session/document_words.h"

namespace tandem::client {

using namespace document;

namespace {

constexpr std::size_t kMostDrawn = 100;   // kept measures, the newest
constexpr double kEnd = 3.0;              // radius of a line's end, pixels
constexpr std::size_t kLongestName = 24;  // bytes, in the scene

const glm::vec3 kLiveShade(0.05f, 0.30f, 0.62f), kKeptShade(0.42f, 0.46f, 0.51f);
const GlyphColour kLive(0.01f, 0.08f, 0.42f, 1.0f), kKept(0.14f, 0.17f, 0.21f, 0.8f),
    kAxis(0.01f, 0.08f, 0.42f, 0.55f);

void addLine(const std::vector<glm::dvec3>& line, const GlyphColour& colour, double pixels,
             GlyphBatch& batch) {
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (i > 0) batch.line(line[i - 1], line[i], pixels, colour);
    batch.sphere(line[i], kEnd * batch.view().pixelAt(line[i]), colour);
  }
}

glm::dvec3 middleOf(const std::vector<glm::dvec3>& line) {
  ASSERT(!line.empty());
  return 0.5 * (line.front() + line.back());
}

std::string wordsOf(const Figure& figure) {
  const std::string value = quantityInWords(documentKind(figure.kind), figure.value);
  return figure.kind == FigureKind::diameter ? "diameter " + value : value;
}

/// The axis of a marked cylinder, a little longer than itself.
void addAxis(const MeasuredPlace& place, GlyphBatch& batch) {
  if (!place.cylinder) return;
  const glm::dvec3 half = 1.15 * place.cylinder->halfLength * place.cylinder->axis;
  batch.line(place.cylinder->middle - half, place.cylinder->middle + half, 1.5, kAxis);
}

/// Each figure's line with its value; the angle of two places stands beside their distance.
void addFigures(const MeasureView& measured, GlyphBatch& batch, std::vector<Label>& labels) {
  std::string angle;
  for (const Figure& figure : measured.figures)
    if (figure.kind == FigureKind::angle) angle = ", " + wordsOf(figure);
  for (const Figure& figure : measured.figures) {
    if (figure.kind == FigureKind::angle) continue;
    addLine(figure.line, kLive, figure.kind == FigureKind::distance ? 2.5 : 2.0, batch);
    const double down = 22.0 * static_cast<double>(figure.kind == FigureKind::clearance) -
                        22.0 * static_cast<double>(figure.kind == FigureKind::across);
    const char* name = figure.kind == FigureKind::clearance ? "clearance "
                       : figure.kind == FigureKind::across  ? "across "
                                                            : "";
    labels.push_back({middleOf(figure.line),
                      {12.0, -20.0 + down},
                      kLiveShade,
                      name + wordsOf(figure) + (figure.kind == FigureKind::distance ? angle : "")});
  }
}

}  // namespace

void markPlace(MeasureUi& ui, const ViewModel& model, PartId part, const glm::dvec3& world) {
  ASSERT(part < model.worldFromPart.size());
  if (ui.marks.size() >= 2) ui.marks.clear();
  ui.marks.push_back({part, transformPoint(inverse(model.worldFromPart[part]), world)});
  ui.chosen = 0;
  ui.open = true;
}

void clearMeasure(MeasureUi& ui) {
  ui.open = ui.open && !ui.marks.empty();
  ui.marks.clear();
  ui.chosen = 0;
}

void measureKey(MeasureUi& ui, const ViewModel& model, PartId underCursor, const glm::dvec3& world) {
  if (!model.measure.possible) return;
  if (underCursor != kNoPart)
    markPlace(ui, model, underCursor, world);
  else if (model.hand.touched != kNoPart)
    markPlace(ui, model, model.hand.touched, model.hand.worldFromProxy.position);
  else if (ui.open)
    clearMeasure(ui);
  else
    ui.open = true;
}

void chooseMeasure(MeasureUi& ui, const Entry& entry, std::size_t partCount) {
  const bool again = ui.chosen == entry.id;
  ui.marks.clear();
  ui.chosen = again ? 0 : entry.id;
  if (again) return;
  const Measure& measure = std::get<Measure>(entry.body);
  const bool one = measure.kind == MeasureKind::length || measure.kind == MeasureKind::diameter;
  for (const Anchor& anchor : measure.anchors)
    if (anchor.part < partCount && ui.marks.size() < (one ? 1u : 2u)) ui.marks.push_back(anchor);
}

std::vector<const Entry*> measureRows(const Document& document) {
  std::vector<const Entry*> rows;
  for (const auto& [id, entry] : document.entries())
    if (std::holds_alternative<Measure>(entry.body)) rows.push_back(&entry);
  std::reverse(rows.begin(), rows.end());
  return rows;
}

std::vector<glm::dvec3> lineOf(const Measure& measure, const ViewModel& model) {
  std::vector<glm::dvec3> line;
  for (const Anchor& anchor : measure.anchors) {
    if (anchor.part != kNoPart && anchor.part >= model.worldFromPart.size()) return {};
    line.push_back(anchor.part == kNoPart ? anchor.point
                                          : transformPoint(model.worldFromPart[anchor.part], anchor.point));
  }
  return line;
}

DocumentWish keepFigure(const Figure& figure, const ViewModel& model) {
  return newEntry(toMeasure(figure, *model.scene, model.worldFromPart));
}

DocumentWish notePlace(const MeasuredPlace& place, const ViewModel& model) {
  Note note = noteAt(model, place.part, place.point);
  note.text = model.scene->parts[place.part].name;
  for (const std::string& line : placeInWords(place)) note.text += ", " + line;
  note.text = printable(note.text, kMaxText);
  return newEntry(std::move(note));
}

void addMeasures(const ViewModel& model, const MeasureUi& ui, GlyphBatch& batch, std::vector<Label>& labels) {
  if (!ui.open) return;
  if (model.document != nullptr) {
    std::vector<const Entry*> rows = measureRows(*model.document);
    if (rows.size() > kMostDrawn) rows.resize(kMostDrawn);
    for (const Entry* entry : rows) {
      const Measure& measure = std::get<Measure>(entry->body);
      const std::vector<glm::dvec3> line = lineOf(measure, model);
      if (line.empty() || entry->id == ui.chosen) continue;
      addLine(line, kKept, 1.5, batch);
      labels.push_back(
          {middleOf(line), {10.0, -10.0}, kKeptShade, quantityInWords(measure.kind, measure.value)});
    }
  }
  for (const Anchor& mark : ui.marks) {
    const glm::dvec3 at = transformPoint(model.worldFromPart[mark.part], mark.point);
    batch.sphere(at, 1.3 * kEnd * batch.view().pixelAt(at), kLive);
  }
  for (const MeasuredPlace& place : model.measure.places) addAxis(place, batch);
  addFigures(model.measure, batch, labels);
}

}  // namespace tandem::client
