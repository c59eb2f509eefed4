#include "client/marks/note_list.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <glm/geometric.hpp>

#include "client/picture/colours.h"
#include "client/session/document_words.h"

namespace tandem::client {

using namespace document;

namespace {

constexpr std::size_t kMostMarks = 200;          // the notes that changed last
constexpr double kPin = 5.0, kPinHeight = 22.0;  // pixels
constexpr double kShare = 0.6;                   // of the part's diagonal that a flight to a note shows
constexpr std::size_t kLongestLabel = 48;        // bytes

std::string counted(std::int64_t count, const char* unit) { return std::to_string(count) + unit; }

}  // namespace

std::vector<NoteRow> noteRows(const Document& document, bool closedToo) {
  std::map<EntryId, NoteRow> threads;
  for (const auto& [id, entry] : document.entries()) {
    if (const auto* note = std::get_if<Note>(&entry.body)) {
      NoteRow& row = threads[id];
      row.entry = &entry;
      row.note = note;
      row.newest = std::max(row.newest, entry.revision);
    } else if (const auto* comment = std::get_if<Comment>(&entry.body)) {
      NoteRow& row = threads[comment->note];
      row.replies.push_back(&entry);
      row.newest = std::max(row.newest, entry.revision);
    }
  }
  std::vector<NoteRow> rows;
  for (auto& [id, row] : threads)
    if (row.note != nullptr && (closedToo || row.note->status != NoteStatus::closed))
      rows.push_back(std::move(row));
  std::sort(rows.begin(), rows.end(), [](const NoteRow& a, const NoteRow& b) { return a.newest > b.newest; });
  return rows;
}

std::vector<const Entry*> viewRows(const Document& document) {
  std::vector<const Entry*> rows;
  for (const auto& [id, entry] : document.entries())
    if (std::holds_alternative<NamedView>(entry.body)) rows.push_back(&entry);
  const auto name = [](const Entry* entry) { return std::get<NamedView>(entry->body).name; };
  std::stable_sort(rows.begin(), rows.end(),
                   [&](const Entry* a, const Entry* b) { return name(a) < name(b); });
  return rows;
}

std::string ageInWords(std::int64_t then, std::int64_t now) {
  const std::int64_t minutes = (now - then) / 60;
  if (minutes < 1) return "now";
  if (minutes < 60) return counted(minutes, " min ago");
  if (minutes < 24 * 60) return counted(minutes / 60, " h ago");
  const std::int64_t days = minutes / (24 * 60);
  return counted(days, days == 1 ? " day ago" : " days ago");
}

std::string byline(const NoteRow& row, std::int64_t now) {
  std::string words = kNoteStatusNames[static_cast<std::size_t>(row.note->status)];
  if (!row.note->assignee.empty()) words += ", for " + row.note->assignee;
  const std::string author = row.entry->authorName.empty() ? "" : row.entry->authorName + " ";
  words += ", " + author + ageInWords(row.entry->made, now);
  if (row.replies.empty()) return words;
  return words + ", " + std::to_string(row.replies.size()) +
         (row.replies.size() == 1 ? " reply" : " replies");
}

bool mayWrite(const ViewModel& model) {
  return model.document != nullptr && !model.replay && model.role != sync::Role::observer;
}

std::optional<glm::dvec3> placeOf(const Note& note, const ViewModel& model) {
  if (note.part == kNoPart) return note.place;
  if (note.part >= model.worldFromPart.size()) return std::nullopt;
  return transformPoint(model.worldFromPart[note.part], note.place);
}

Note noteAt(const ViewModel& model, PartId part, const glm::dvec3& world) {
  Note note;
  note.part = part;
  note.place = part == kNoPart ? world : transformPoint(inverse(model.worldFromPart[part]), world);
  return note;
}

DocumentWish newEntry(Body body) { return {DocumentWish::Kind::change, {0, 0, std::move(body)}}; }

Camera cameraForNote(const Camera& from, const glm::dvec3& place, double diagonal) {
  Camera camera = from;
  camera.target = place;
  if (diagonal > 0.0) camera.distance = kShare * diagonal / std::tan(0.5 * camera.fieldOfView);
  return camera;
}

Camera cameraOfView(const NamedView& view, const Camera& like) {
  Camera near = like;
  if (view.distance > 0.0) near.distance = view.distance;
  return cameraAt(view.worldFromCamera, near);
}

NamedView viewAs(std::string name, const Camera& camera, const SectionSet& sections,
                 const PartDisplay& parts) {
  NamedView view{std::move(name), worldFromCamera(camera), camera.distance, sections.planes(), false, {},
                 parts.style};
  std::vector<PartId> shown;
  for (std::size_t p = 0; p < parts.partCount(); ++p) {
    const auto part = static_cast<PartId>(p);
    (parts.visible(part) ? shown : view.parts).push_back(part);
  }
  view.onlyThese = shown.size() < view.parts.size();
  if (view.onlyThese) view.parts = std::move(shown);
  if (view.parts.size() > kMaxListed) view.parts.resize(kMaxListed);
  view.seenThrough = seenThroughOf(parts.partCount(), [&](PartId part) { return parts.transparent(part); });
  return view;
}

void applyView(const NamedView& view, SectionSet& sections, PartDisplay& parts) {
  sections = SectionSet(view.sections);
  std::vector<PartId> known = view.parts;
  std::erase_if(known, [&](PartId part) { return part >= parts.partCount(); });
  parts.showAll();
  parts.style = view.style;
  std::erase_if(parts.style.apart, [&](PartId part) { return part >= parts.partCount(); });
  for (std::size_t p = 0; p < parts.partCount() && view.seenThrough.allBut; ++p)
    parts.setTransparent(static_cast<PartId>(p), true);
  for (const PartId part : view.seenThrough.parts)
    if (part < parts.partCount()) parts.setTransparent(part, !view.seenThrough.allBut);
  if (view.onlyThese && !known.empty()) return parts.isolate(known);
  for (const PartId part : known) parts.setHidden(part, true);
}

glm::vec3 noteColour(NoteStatus status) {
  switch (status) {
    case NoteStatus::open:
      return {0.83f, 0.42f, 0.02f};
    case NoteStatus::inProgress:
      return {0.16f, 0.42f, 0.82f};
    case NoteStatus::resolved:
      return {0.10f, 0.55f, 0.29f};
    case NoteStatus::closed:
      break;
  }
  return {0.42f, 0.46f, 0.51f};
}

namespace {

/// A pin that stands on the place, upright on the screen.
void addPin(const glm::dvec3& place, const glm::vec3& srgbColour, bool chosen, GlyphBatch& batch) {
  const View& view = batch.view();
  const double px = view.pixelAt(place);
  const glm::dvec3 up = view.worldFromEye.orientation * glm::dvec3(0.0, 1.0, 0.0);
  const GlyphColour colour(linear(srgbColour), 1.0f);
  const glm::dvec3 head = place + kPinHeight * px * up;
  batch.cone(place, head, 0.0, 0.45 * kPin * px, colour);
  batch.sphere(head, (chosen ? 1.6 : 1.0) * kPin * px, colour);
}

}  // namespace

void addNotes(const ViewModel& model, const NoteUi& ui, GlyphBatch& batch, std::vector<Label>& labels) {
  if (model.document == nullptr) return;
  constexpr glm::dvec2 kBesidePin(9.0, -32.0);  // pixels
  std::vector<NoteRow> rows = noteRows(*model.document, true);
  std::erase_if(rows, [&](const NoteRow& row) {
    return row.note->status == NoteStatus::closed && !ui.closedToo && row.entry->id != ui.chosen;
  });
  if (rows.size() > kMostMarks) rows.resize(kMostMarks);
  for (const NoteRow& row : rows) {
    const std::optional<glm::dvec3> place = placeOf(*row.note, model);
    if (!place) continue;
    const bool chosen = row.entry->id == ui.chosen;
    const glm::vec3 colour = noteColour(row.note->status);
    addPin(*place, colour, chosen, batch);
    const std::string number = std::to_string(row.entry->id);
    labels.push_back({*place, kBesidePin, colour,
                      chosen ? number + "  " + shortened(row.note->text, kLongestLabel) : number});
  }
  if (!ui.draft) return;
  if (const std::optional<glm::dvec3> place = placeOf(*ui.draft, model)) {
    addPin(*place, noteColour(NoteStatus::open), true, batch);
    labels.push_back({*place, kBesidePin, noteColour(NoteStatus::open), "new note"});
  }
}

}  // namespace tandem::client
