#pragma once

// What the person in a window shows the others, and what of theirs is followed here: sections, or a whole
// view (camera, sections, hidden parts, how parts are drawn, selection, the marks of a clash, an open
// measure). What is followed stands in the window's own state; how that was before is kept, and comes back
// when the following ends.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/marks/hand_glyphs.h"
#include "client/marks/measure_list.h"
#include "client/marks/part_display.h"
#include "client/marks/section_set.h"
#include "client/picture/glyphs.h"
#include "client/session/presenting_view.h"
#include "sync/wire/limits.h"

namespace tandem::client {

class SharedView {
 public:
  explicit SharedView(bool follows = true) : following_(follows) {}

  sync::Shares shares = sync::Shares::nothing;  // what this person shares
  bool pointing = false;                        // the person points at what is under the cursor

  /// What a window has that a view changes.
  struct Window {
    SectionSet& sections;
    PartDisplay& parts;
    MeasureUi& measures;
    SiteId& camera;  // the site whose camera this one follows; the person's own moves set it to none
  };
  /// Follows what another shares, or ends that. Once a frame, after the person's input and before the camera
  /// is moved.
  void follow(const ViewModel& model, Window window);
  const Following& following() const { return following_; }
  void setFollows(bool follows) { following_.follow(follows); }
  /// Whether what is shared later will be followed too.
  void followLater(bool follows) { following_.followLater(follows); }
  /// Points at a place of a part, as a script does, whatever is under the cursor; a part of none: no more.
  void pointAt(const document::Anchor& place) {
    scriptPoint_.reset();
    if (place.part != kNoPart) scriptPoint_ = place;
  }
  /// Looks at a clash as a script does, whatever the list of clashes has; of no parts: no more.
  void lookAtClash(const sync::Inspection& clash) { scriptClash_ = clash; }
  /// The clash whose marks are drawn besides those of the window's own list: of the view that is followed, or
  /// of a script.
  const sync::Inspection& clash(const ViewModel& model) const {
    return following_.followsView() ? model.presenting.shared.inspection : scriptClash_;
  }
  /// Ends that at once, before something else changes the window.
  void stop(Window window);

  /// What a person has open in the window, for the others to see.
  struct Seen {
    const SectionSet& sections;
    const PartDisplay& parts;
    const MeasureUi& measures;
    const sync::Inspection& clash;  // chosen in the window's list
  };
  /// What the others are shown. `under`: the place under the cursor, world; `part`: whose that is.
  sync::Presentation shown(const ViewModel& model, const Seen& seen, PartId part,
                           const glm::dvec3& under) const;

 private:
  struct Kept {
    SectionSet sections;
    std::optional<PartDisplay> parts;   // of a view that changed them
    std::optional<MeasureUi> measures;  // of a view with a measure
  };
  void takeOver(const PresentingView& presenting, Window window);
  void takeOverMeasure(const sync::Inspection& looks, MeasureUi& measures);
  void giveBack(Window window);

  Following following_;
  std::optional<Kept> own_;    // as it was before it was followed
  SiteId leader_ = kNoSite;    // whose view is followed
  PartId selected_ = kNoPart;  // by the leader, when it was taken over last
  std::uint32_t ended_ = 0;
  std::optional<document::Anchor> scriptPoint_;
  sync::Inspection scriptClash_;
};

/// What the person is writing to all.
struct ChatUi {
  std::array<char, sync::kMaxSayLength + 1> text{};
  bool opened = false;      // the list was opened for its first line
  std::uint64_t lines = 0;  // the number of the last one that was drawn
};

/// "Ada presents: you follow"; empty if nobody shares anything.
std::string sharingInWords(const ViewModel& model, const SharedView& shared);
/// Adds a mark and the name of each other person who points at a place.
void addPoints(const ViewModel& model, GlyphBatch& batch, std::vector<Label>& labels);

}  // namespace tandem::client
