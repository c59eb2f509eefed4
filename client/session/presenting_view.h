#pragma once

// What people show and say to each other, as a site's window or terminal gets it, and this person's part in
// it on its way back.

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include "sync/wire/limits.h"
#include "sync/wire/presentation_messages.h"

namespace tandem::client {

/// A message to all.
struct ChatLine {
  std::uint64_t number = 0;  // of this site's lines, from 1
  bool earlier = false;      // it was said before this site came, or while it was away
  sync::SaidLine line;
};

/// Puts lines behind others, of which a site keeps the newest.
inline void addChat(std::vector<ChatLine>& chat, std::vector<ChatLine> lines) {
  std::move(lines.begin(), lines.end(), std::back_inserter(chat));
  if (chat.size() > sync::kMaxSaidLines)
    chat.erase(chat.begin(), chat.end() - static_cast<std::ptrdiff_t>(sync::kMaxSaidLines));
}

/// What others share and point at.
struct PresentingView {
  sync::Presentation shared;               // by the other site that shares; site kNoSite: none does
  std::uint32_t begun = 0;                 // how often another site has begun to share
  std::uint32_t ended = 0;                 // how often the server has ended what this site shared
  std::vector<sync::Presentation> points;  // of the others that point at a place

  /// A part that the sharing site has hidden in its view, or made transparent.
  bool hides(PartId part) const { return has(shared.hidden, part); }
  bool seesThrough(PartId part) const { return has(shared.transparent, part); }

 private:
  static bool has(const std::vector<std::uint8_t>& parts, PartId part) {
    const std::size_t byte = part / 8u;
    return byte < parts.size() && (parts[byte] >> part % 8u & 1u) != 0;
  }
};

/// How a person sees the parts of the scene, by tests of each part.
template <typename Hides, typename SeesThrough>
struct SeenParts {
  std::size_t count = 0;
  PartId selected = kNoPart;
  const document::PartStyle& style;
  const sync::Inspection& inspection;
  Hides hides;
  SeesThrough seesThrough;
};

/// The parts that a view shows as transparent, by a test of each.
template <typename SeesThrough>
document::SeenThrough seenThroughOf(std::size_t partCount, const SeesThrough& seesThrough) {
  std::vector<PartId> through, others;
  for (std::size_t p = 0; p < partCount; ++p)
    (seesThrough(static_cast<PartId>(p)) ? through : others).push_back(static_cast<PartId>(p));
  document::SeenThrough seen{others.size() < through.size(), {}};
  seen.parts = std::move(seen.allBut ? others : through);
  if (seen.parts.size() > document::kMaxSeenThrough) seen.parts.resize(document::kMaxSeenThrough);
  return seen;
}

/// Puts what a person sees into what the others are shown, as far as it is shared.
template <typename Hides, typename SeesThrough>
void shareView(sync::Presentation& shown, const std::vector<document::SectionPlane>& sections,
               const SeenParts<Hides, SeesThrough>& seen) {
  shown.sections.clear();
  shown.hidden.clear();
  shown.transparent.clear();
  shown.selected = kNoPart;
  shown.style = {};
  shown.inspection = {};
  if (shown.shares != sync::Shares::nothing) shown.sections = sections;
  if (shown.shares != sync::Shares::view) return;
  shown.selected = seen.selected;
  shown.style = seen.style;
  shown.inspection = seen.inspection;
  const auto add = [](std::vector<std::uint8_t>& parts, std::size_t part) {
    parts.resize(part / 8 + 1);
    parts.back() = static_cast<std::uint8_t>(parts.back() | 1u << part % 8);
  };
  for (std::size_t part = 0; part < seen.count; ++part) {
    if (seen.hides(static_cast<PartId>(part))) add(shown.hidden, part);
    if (seen.seesThrough(static_cast<PartId>(part))) add(shown.transparent, part);
  }
}

/// Whether this person follows what another shares: everything that is newly shared, until they stop.
class Following {
 public:
  explicit Following(bool follows = true) : wants_(follows), follows_(follows) {}

  /// Takes note of what is shared now. A person who shares follows nobody.
  void update(const PresentingView& presenting, sync::Shares own) {
    if (begun_ != presenting.begun) follows_ = wants_;
    begun_ = presenting.begun;
    shares_ = own == sync::Shares::nothing && presenting.shared.site != kNoSite ? presenting.shared.shares
                                                                                : sync::Shares::nothing;
  }
  void follow(bool follows) { follows_ = follows; }
  /// Whether what is shared later will be followed too.
  void followLater(bool follows) { wants_ = follows_ = follows; }

  /// Whether another's sections, or view, are those of this site now.
  bool followsSections() const { return follows_ && shares_ != sync::Shares::nothing; }
  bool followsView() const { return follows_ && shares_ == sync::Shares::view; }

 private:
  bool wants_, follows_;
  std::uint32_t begun_ = 0;
  sync::Shares shares_ = sync::Shares::nothing;  // by another
};

}  // namespace tandem::client
