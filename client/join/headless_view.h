#pragma once

// What a person without a window sees and shows: the camera, the section planes and hidden parts of the site,
// as options and a script set them, and what others share, which is followed as in a window.
//
// Main thread.

#include <utility>
#include <vector>

#include "client/hand/hand_script.h"
#include "client/session/presenting_view.h"
#include "client/session/view_model.h"

namespace tandem::client {

class HeadlessView {
 public:
  HeadlessView(const Camera& camera, std::vector<document::SectionPlane> sections, bool follows,
               document::PartStyle style = {})
      : camera_(camera), sections_(std::move(sections)), style_(std::move(style)), following_(follows) {}

  /// A step of a script that the others see; a message is said by the next act().
  void perform(const ScriptStep& step, const ViewModel& model);
  /// Takes note of what others share, and says what this site does now.
  ViewActions act(const ViewModel& model);

  const Camera& camera() const { return camera_; }
  const Following& following() const { return following_; }
  sync::Shares shares() const { return shown_.shares; }
  /// The planes in effect, whoever set them.
  const std::vector<document::SectionPlane>& sections(const ViewModel& model) const;
  /// How parts are drawn, likewise.
  const document::PartStyle& style(const ViewModel& model) const;
  const std::vector<PartId>& hidden() const { return hidden_; }
  /// The clash and the measure that this person looks at, whoever looks besides.
  const sync::Inspection& inspection() const { return inspection_; }
  /// Puts what this person sees into a view that is kept, all but the camera, which stands in it already.
  void keepIn(document::NamedView& view, const ViewModel& model) const;

 private:
  Camera camera_;
  std::vector<document::SectionPlane> sections_;  // this person's own
  document::PartStyle style_;                     // the same
  std::vector<PartId> hidden_;
  PartId selected_ = kNoPart;
  sync::Inspection inspection_;
  sync::Presentation shown_;
  std::vector<sync::Say> says_;
  Following following_;
  std::uint32_t ended_ = 0;
};

/// What the verbs `explode`, `colour` and `ghosts` make of how parts are drawn.
void changeStyle(const ScriptStep& step, document::PartStyle& style);
/// The place of a part that is nearest to this site's hand, in its frame; none of no part.
document::Anchor nearestToHand(PartId part, const ViewModel& model);
/// The camera that looks from one place at another, with the field of view of `like`.
Camera cameraFrom(const glm::dvec3& from, const glm::dvec3& to, const Camera& like);

}  // namespace tandem::client
