#pragma once

// What people of a session agree on besides the poses of parts: views, notes, measures, verdicts, saved
// states, groups, names. Each is an entry of one document; entries refer to each other by id.
//
// A new kind is a struct here, its place at the end of Body, its name in kKindNames, and its fields in
// describe.h: wire, journal, JSON and the check of limits follow from these.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "assets/base/ids.h"
#include "assets/base/pose.h"

namespace tandem::document {

/// Given by the server, never twice in a session; 0 is none.
using EntryId = std::uint64_t;
/// The server's order of all changes of the document, from 1.
using Revision = std::uint64_t;

inline constexpr std::size_t kMaxName = 128;          // bytes, UTF-8
inline constexpr std::size_t kMaxText = 2000;         // bytes, UTF-8
inline constexpr std::size_t kMaxSections = 8;        // of a view
inline constexpr std::size_t kMaxAnchors = 4;         // of a measure
inline constexpr std::size_t kMaxListed = 4096;       // parts of a view or a group
inline constexpr std::size_t kMaxApart = 2048;        // parts that a view draws apart, unless it is all
inline constexpr std::size_t kMaxSeenThrough = 1024;  // parts of a view that are transparent, or are not
inline constexpr std::size_t kMaxPoses = 240;         // of a saved state; larger ones are several entries

/// The entry is no more. Its id is kept for a while, so that whoever removed it can take that back.
struct Removed {};

/// What lies in front of the plane is cut away.
struct SectionPlane {
  glm::dvec3 point{0.0, 0.0, 0.0};   // m, world
  glm::dvec3 normal{0.0, 1.0, 0.0};  // world, of any length
};
enum class PartColouring : std::uint8_t {
  asMade,
  byBody,      // parts of one mesh alike
  byMaterial,  // by that of a part's first face
  byOwner      // pale, but for those that somebody holds
};
inline constexpr std::array<const char*, 4> kColouringNames{"as made", "by body", "by material", "by owner"};
/// By its name, or that without "by "; nothing if there is none.
inline std::optional<PartColouring> colouringNamed(std::string_view name) {
  for (std::size_t i = 0; i < kColouringNames.size(); ++i) {
    const std::string_view known = kColouringNames[i];
    if (name == known || "by " + std::string(name) == known) return static_cast<PartColouring>(i);
  }
  return std::nullopt;
}
/// How the parts of a view are drawn, besides which of them.
struct PartStyle {
  double explode = 0.0;       // 0..1: how far parts are drawn from each other; 0: where they are
  std::vector<PartId> apart;  // of these alone, from their middle; none: of all parts
  PartColouring colouring = PartColouring::asMade;
  bool ghosts = false;  // what is hidden is still seen, faintly
  friend bool operator==(const PartStyle&, const PartStyle&) = default;
};
/// Which parts of a view are transparent.
struct SeenThrough {
  bool allBut = false;  // all but `parts` are, else `parts`
  std::vector<PartId> parts;
  friend bool operator==(const SeenThrough&, const SeenThrough&) = default;
};
struct NamedView {
  std::string name;
  Pose worldFromCamera;
  double distance = 1.0;  // m, from the camera to the point that it turns about
  std::vector<SectionPlane> sections;
  bool onlyThese = false;  // `parts` are all that is shown; else they are hidden
  std::vector<PartId> parts;
  PartStyle style;
  SeenThrough seenThrough{};
};

enum class NoteStatus : std::uint8_t { open, inProgress, resolved, closed };
inline constexpr std::array<const char*, 4> kNoteStatusNames{"open", "in progress", "resolved", "closed"};
/// The first text of a thread, pinned to a place on a part or in the world.
struct Note {
  std::string text;
  PartId part = kNoPart;            // none: the place is in the world
  glm::dvec3 place{0.0, 0.0, 0.0};  // m, in the frame of the part
  std::string assignee;             // a person's name; may be empty
  NoteStatus status = NoteStatus::open;
};
/// A further text of a note's thread.
struct Comment {
  EntryId note = 0;
  std::string text;
};

enum class MeasureKind : std::uint8_t { distance, length, diameter, angle, clearance };
inline constexpr std::array<const char*, 5> kMeasureNames{"distance", "length", "diameter", "angle",
                                                          "clearance"};
struct Anchor {
  PartId part = kNoPart;
  glm::dvec3 point{0.0, 0.0, 0.0};  // m, in the frame of the part
  friend bool operator==(const Anchor&, const Anchor&) = default;
};
struct Measure {
  std::string name;
  MeasureKind kind = MeasureKind::distance;
  double value = 0.0;  // m, of an angle rad
  std::vector<Anchor> anchors;
};

enum class ClashStatus : std::uint8_t { fresh, active, reviewed, approved, resolved };
inline constexpr std::array<const char*, 5> kClashStatusNames{"new", "active", "reviewed", "approved",
                                                              "resolved"};
struct ClashVerdict {
  PartId a = kNoPart, b = kNoPart;
  ClashStatus status = ClashStatus::fresh;
  double depth = 0.0;  // m, when it was judged
  std::string text;
};

struct PartPose {
  PartId part = kNoPart;
  Pose worldFromPart;
};
/// Where parts were. A state of more than kMaxPoses parts is several entries of one name.
struct SavedPoses {
  std::string name;
  std::vector<PartPose> poses;
};
struct Group {
  std::string name;
  std::vector<PartId> parts;
};
/// A part's name in this session. Of several the one that was changed last counts.
struct PartName {
  PartId part = kNoPart;
  std::string name;
};

using Body =
    std::variant<Removed, NamedView, Note, Comment, Measure, ClashVerdict, SavedPoses, Group, PartName>;
/// By the index in Body.
inline constexpr std::array<const char*, std::variant_size_v<Body>> kKindNames{
    "removed", "view", "note", "comment", "measure", "clash", "poses", "group", "name"};

struct Entry {
  EntryId id = 0;
  Revision revision = 0;       // of its last change
  SiteId author = kNoSite;     // who made it; none: it was read from a file
  std::uint32_t creation = 0;  // the author's request that made it
  std::string authorName;      // at that time
  std::int64_t made = 0;       // Unix time, s
  SiteId editor = kNoSite;     // who changed it last
  std::uint32_t request = 0;   // of the editor, for that change
  std::int64_t changed = 0;    // Unix time, s
  Body body;

  bool removed() const { return std::holds_alternative<Removed>(body); }
};

/// A change that somebody wants: a new entry, another body for one, or its removal.
struct Change {
  EntryId id = 0;     // 0: a new entry
  Revision base = 0;  // the revision of the entry that is changed; 0 for a new one
  Body body;
};

}  // namespace tandem::document
