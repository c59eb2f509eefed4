#pragma once

// The notes and views of the session's document apart from how they are drawn: the list in words, where
// notes are now, the cameras that show them, and the changes that a person makes.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/marks/hand_glyphs.h"
#include "client/marks/part_display.h"
#include "client/marks/section_set.h"
#include "client/picture/glyphs.h"

namespace tandem::client {

/// How the window was before a flight to a note or a view.
struct NoteBack {
  Camera camera;
  std::optional<SectionSet> sections;  // of a view that changed them
  std::optional<PartDisplay> parts;    // the same
};

/// What the person set, chose and is writing.
struct NoteUi {
  bool open = false;                    // the list is shown
  bool wanted = false;                  // the list is to be shown from this frame on
  bool choosesFirst = false;            // the first note of the list becomes the chosen one
  bool closedToo = false;               // closed notes are listed and marked as well
  document::EntryId chosen = 0;         // a note; 0: none
  document::EntryId flyTo = 0;          // the note or view that the camera is to move to; 0: none
  bool goBack = false;                  // the camera is to move to `back`
  std::optional<NoteBack> back;         // from before the first flight
  bool keepsView = false;               // what is seen now is to be kept as `viewName`
  std::optional<document::Note> draft;  // is being written; its place stands
  bool focus = false;                   // the draft's text is to get the keyboard
  std::array<char, document::kMaxText + 1> text{}, reply{};
  std::array<char, document::kMaxName + 1> viewName{};
};

/// A note with its thread.
struct NoteRow {
  const document::Entry* entry = nullptr;
  const document::Note* note = nullptr;
  std::vector<const document::Entry*> replies;  // oldest first
  document::Revision newest = 0;                // of the note and its replies
};

/// The notes, the thread that changed last first. Points into the document.
std::vector<NoteRow> noteRows(const document::Document& document, bool closedToo);
/// The views, by name. Points into the document.
std::vector<const document::Entry*> viewRows(const document::Document& document);

/// "in progress, for ben, ada 5 min ago, 2 replies"; `now` in Unix time, s.
std::string byline(const NoteRow& row, std::int64_t now);
/// "now", "5 min ago", "3 h ago", "2 days ago".
std::string ageInWords(std::int64_t then, std::int64_t now);

/// Whether this person may write in the document now.
bool mayWrite(const ViewModel& model);
/// The place of a note in the world, which follows its part; nothing if the scene has no such part.
std::optional<glm::dvec3> placeOf(const document::Note& note, const ViewModel& model);
/// A note without text at a place in the world, on a part or on none.
document::Note noteAt(const ViewModel& model, PartId part, const glm::dvec3& world);

DocumentWish newEntry(document::Body body);
/// The note of an entry with other members, as `change` makes them.
template <typename Change>
DocumentWish changedNote(const document::Entry& entry, const Change& change) {
  document::Note note = std::get<document::Note>(entry.body);
  change(note);
  return {DocumentWish::Kind::change, {entry.id, entry.revision, std::move(note)}};
}

/// A camera that looks from where `from` does, nearer, at a place on a part with this diagonal, m.
Camera cameraForNote(const Camera& from, const glm::dvec3& place, double diagonal);
/// The camera of a view, with the field of view of `like`.
Camera cameraOfView(const document::NamedView& view, const Camera& like);

/// What is seen now, as a view; and the other way round.
document::NamedView viewAs(std::string name, const Camera& camera, const SectionSet& sections,
                           const PartDisplay& parts);
void applyView(const document::NamedView& view, SectionSet& sections, PartDisplay& parts);

/// Adds a pin and the number of each note that is not closed, and of the chosen one its text.
void addNotes(const ViewModel& model, const NoteUi& ui, GlyphBatch& batch, std::vector<Label>& labels);

/// sRGB of a note's mark.
glm::vec3 noteColour(document::NoteStatus status);

}  // namespace tandem::client
