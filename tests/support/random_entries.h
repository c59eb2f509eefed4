#pragma once

// Random sound bodies of every kind, and random changes of a document, for round trips and replicas.

#include <random>

#include "assets/document/document.h"

namespace tandem::document::testing {

class RandomEntries {
 public:
  explicit RandomEntries(std::uint64_t seed) : random_(seed) {}

  std::uint32_t number(std::uint32_t below) { return static_cast<std::uint32_t>(random_() % below); }
  double real(double range) { return range * (2.0 * static_cast<double>(random_() >> 11) * 0x1p-53 - 1.0); }
  glm::dvec3 vector() { return glm::dvec3(real(5.0), real(5.0), real(5.0)); }
  Pose pose() { return {vector(), fromRotationVector(vector())}; }
  PartId part() { return static_cast<PartId>(number(100)); }
  std::string text(std::size_t longest) {
    static const char* const kPieces[] = {"a", "Z", " ", "\"", "\xc3\xa9", "\xe2\x82\xac"};
    std::string out;
    for (std::uint32_t n = number(20); n > 0; --n)
      if (out.size() + 3 <= longest) out += kPieces[number(6)];
    return out;
  }
  std::vector<PartId> parts() {
    std::vector<PartId> parts;
    for (std::uint32_t n = number(5); n > 0; --n) parts.push_back(part());
    return parts;
  }

  /// A sound body of the kind with this index in Body. Comments refer to `note`.
  Body body(std::size_t kind, EntryId note) {
    switch (kind) {
      case 1: {
        NamedView view{text(kMaxName), pose(), 1.5, {}, number(2) == 0, parts(), {}};
        for (std::uint32_t n = number(3); n > 0; --n) view.sections.push_back({vector(), vector()});
        if (number(2) == 0)
          view.style = {0.25 * number(5), parts(), static_cast<PartColouring>(number(4)), number(2) == 0};
        if (number(2) == 0) view.seenThrough = {number(2) == 0, parts()};
        return view;
      }
      case 2:
        return Note{text(kMaxText), number(3) == 0 ? kNoPart : part(), vector(), text(kMaxName),
                    static_cast<NoteStatus>(number(4))};
      case 3:
        return Comment{note, text(kMaxText)};
      case 4: {
        Measure measure{text(kMaxName), static_cast<MeasureKind>(number(5)), real(3.0), {}};
        for (std::uint32_t n = number(4); n > 0; --n) measure.anchors.push_back({part(), vector()});
        return measure;
      }
      case 5:
        return ClashVerdict{part(), part(), static_cast<ClashStatus>(number(5)), 0.25, text(kMaxText)};
      case 6: {
        SavedPoses saved{text(kMaxName), {}};
        for (std::uint32_t n = number(5); n > 0; --n) saved.poses.push_back({part(), pose()});
        return saved;
      }
      case 7:
        return Group{text(kMaxName), parts()};
      case 8:
        return PartName{part(), text(kMaxName)};
      default:
        return Removed{};
    }
  }

  /// A change that the document will accept as a rule.
  Change change(const Document& document) {
    EntryId note = 0;
    std::vector<const Entry*> all;
    for (const auto& [id, entry] : document.entries()) {
      all.push_back(&entry);
      if (std::holds_alternative<Note>(entry.body) && (note == 0 || number(2) == 0)) note = id;
    }
    const auto kind = 1 + number(static_cast<std::uint32_t>(kKindNames.size() - 1));
    if (all.empty() || number(2) == 0) return {0, 0, body(note == 0 && kind == 3 ? 2 : kind, note)};
    const Entry& entry = *all[number(static_cast<std::uint32_t>(all.size()))];
    if (!entry.removed() && number(3) == 0) return {entry.id, entry.revision, Removed{}};
    const std::size_t same = entry.removed() ? 2 : entry.body.index();
    return {entry.id, entry.revision, body(same, note)};
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace tandem::document::testing
