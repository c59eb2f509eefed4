#pragma once

// What one person shows the others, and what people say to each other. Of a presentation the newest counts;
// of what was said the server keeps the newest lines, and tells them to whoever joins.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "assets/base/ids.h"
#include "assets/document/entry.h"

namespace tandem::sync {

/// What of this person's window the others follow. A view has the sections with it.
enum class Shares : std::uint8_t { nothing, sections, view };
inline constexpr std::array<const char*, 3> kSharesNames{"nothing", "sections", "view"};

/// What is known of two parts that clash: a pair is only marked, all else has a place on each of them.
enum class ClashMark : std::uint8_t { pair, depth, unknownDepth, touch, clearance };
inline constexpr std::array<const char*, 5> kClashMarkNames{"pair", "depth", "unknown depth", "touch",
                                                            "clearance"};
inline constexpr std::size_t kMaxMarks = 2;  // of a measure

/// What a person looks at closely: two parts that clash, and a measure that is open.
struct Inspection {
  PartId a = kNoPart, b = kNoPart;  // the parts that clash; none: no clash is looked at
  ClashMark mark = ClashMark::pair;
  double amount = 0.0;            // m: how deep, or how far apart
  bool moved = false;             // the parts have moved to each other since that was measured
  glm::dvec3 onA{0.0}, onB{0.0};  // m: the place on each part, in its frame
  bool measuring = false;
  std::vector<document::Anchor> marks;  // the places that are measured
  friend bool operator==(const Inspection&, const Inspection&) = default;
};

/// What a site shows now; from the server: what another site shows, or that it ended what this site shared.
/// One site shares at a time. The camera of a view is that of the site's presence.
struct Presentation {
  SiteId site = kNoSite;  // whose; the server knows, whatever a site says
  Shares shares = Shares::nothing;
  std::vector<document::SectionPlane> sections;
  PartId selected = kNoPart;              // of a view
  std::vector<std::uint8_t> hidden;       // of a view: bit p % 8 of byte p / 8 is that of part p
  std::vector<std::uint8_t> transparent;  // the same
  document::PartStyle style;              // of a view
  Inspection inspection;                  // of a view
  PartId pointedAt = kNoPart;             // the part that the person points at
  glm::dvec3 place{0.0, 0.0, 0.0};        // m, in the frame of that part

  /// Leaves of it the place that it points at.
  void endSharing() {
    shares = Shares::nothing;
    sections.clear();
    selected = kNoPart;
    hidden.clear();
    transparent.clear();
    style = {};
    inspection = {};
  }
};

/// A short message to all. Each name in square brackets is a link to the part in the same place of `parts`.
struct Say {
  std::string text;
  std::vector<PartId> parts;
  friend bool operator==(const Say&, const Say&) = default;
};

/// A message as the server tells it to all.
struct SaidLine {
  std::uint64_t number = 0;  // of the session's lines, from 1
  std::int64_t at = 0;       // Unix time, s
  SiteId site = kNoSite;     // who said it
  std::string name;          // of who said it, at that time
  Say said;
  friend bool operator==(const SaidLine&, const SaidLine&) = default;
};

/// From the server: lines in the order of their numbers.
struct Said {
  bool earlier = false;  // they were said before the site came into the session, or while it was away
  std::vector<SaidLine> lines;
};

}  // namespace tandem::sync
