#pragma once

// The fields of every kind of entry, each written down once with its limit. An archive visits them: the check
// of limits (entry_check.cpp), JSON (document_json.cpp), the bytes of wire and journal
// (sync/wire/document_codec.cpp). It has
//   text(name, std::string, limit)        UTF-8 without control characters
//   real(name, double, least, most)       finite
//   vector(name, glm::dvec3)              each coordinate within kFarthest
//   pose(name, Pose), flag(name, bool)
//   part(name, PartId, Needed)            none is allowed unless it is needed
//   entry(name, EntryId)                  of another entry, which must be there
//   choice(name, enumeration, names)
//   parts(name, std::vector<PartId>, limit)
//   list(name, std::vector<T>, limit)     of records with fields of their own
//   addition(name, T, another)            a record that came later, behind all else of its body: what is as
//                                         in T{} is not written, unless another one behind it is, and what
//                                         is not there is as in T{}

#include <concepts>
#include <type_traits>

#include "assets/document/entry.h"

namespace tandem::document {

inline constexpr double kFarthest = 1e9;  // m

/// Matches T and const T.
template <typename Record, typename T>
concept Is = std::same_as<std::remove_const_t<Record>, T>;
enum class Needed : bool { no, yes };

void fields(auto&, Is<Removed> auto&) {}
void fields(auto& a, Is<SectionPlane> auto& s) {
  a.vector("point", s.point);
  a.vector("normal", s.normal);
}
void fields(auto& a, Is<PartStyle> auto& s) {
  a.real("explode", s.explode, 0.0, 1.0);
  a.parts("apart", s.apart, kMaxApart);
  a.choice("colours", s.colouring, kColouringNames);
  a.flag("ghosts", s.ghosts);
}
void fields(auto& a, Is<SeenThrough> auto& s) {
  a.flag("all_but", s.allBut);
  a.parts("parts", s.parts, kMaxSeenThrough);
}
void fields(auto& a, Is<NamedView> auto& v) {
  a.text("name", v.name, kMaxName);
  a.pose("camera", v.worldFromCamera);
  a.real("distance_m", v.distance, 0.0, kFarthest);
  a.list("sections", v.sections, kMaxSections);
  a.flag("only_these", v.onlyThese);
  a.parts("parts", v.parts, kMaxListed);
  a.addition("style", v.style, v.seenThrough != SeenThrough{});
  a.addition("seen_through", v.seenThrough, false);
}
void fields(auto& a, Is<Note> auto& n) {
  a.text("text", n.text, kMaxText);
  a.part("part", n.part, Needed::no);
  a.vector("place_m", n.place);
  a.text("assignee", n.assignee, kMaxName);
  a.choice("status", n.status, kNoteStatusNames);
}
void fields(auto& a, Is<Comment> auto& c) {
  a.entry("note", c.note);
  a.text("text", c.text, kMaxText);
}
void fields(auto& a, Is<Anchor> auto& n) {
  a.part("part", n.part, Needed::no);
  a.vector("point_m", n.point);
}
void fields(auto& a, Is<Measure> auto& m) {
  a.text("name", m.name, kMaxName);
  a.choice("measures", m.kind, kMeasureNames);
  a.real("value", m.value, -kFarthest, kFarthest);
  a.list("anchors", m.anchors, kMaxAnchors);
}
void fields(auto& a, Is<ClashVerdict> auto& c) {
  a.part("a", c.a, Needed::yes);
  a.part("b", c.b, Needed::yes);
  a.choice("status", c.status, kClashStatusNames);
  a.real("depth_m", c.depth, 0.0, kFarthest);
  a.text("text", c.text, kMaxText);
}
void fields(auto& a, Is<PartPose> auto& p) {
  a.part("part", p.part, Needed::yes);
  a.pose("pose", p.worldFromPart);
}
void fields(auto& a, Is<SavedPoses> auto& s) {
  a.text("name", s.name, kMaxName);
  a.list("poses", s.poses, kMaxPoses);
}
void fields(auto& a, Is<Group> auto& g) {
  a.text("name", g.name, kMaxName);
  a.parts("parts", g.parts, kMaxListed);
}
void fields(auto& a, Is<PartName> auto& n) {
  a.part("part", n.part, Needed::yes);
  a.text("name", n.name, kMaxName);
}

/// A body of the kind with this index in Body, all members at their defaults.
template <std::size_t I = 0>
Body bodyOfKind(std::size_t kind) {
  if constexpr (I < std::variant_size_v<Body>) {
    if (kind == I) return Body(std::in_place_index<I>);
    return bodyOfKind<I + 1>(kind);
  } else {
    return Removed{};
  }
}

}  // namespace tandem::document
