#pragma once

// Which parts a person wants to see and how. With ownership and touch this gives the look of each part.

#include <vector>

#include "client/marks/part_colouring.h"
#include "client/picture/scene_renderer.h"
#include "client/session/view_model.h"

namespace tandem::client {

class PartDisplay {
 public:
  explicit PartDisplay(std::size_t partCount)
      : hidden_(partCount), transparent_(partCount), isolated_(partCount) {}

  std::size_t partCount() const { return hidden_.size(); }
  bool visible(PartId part) const { return !hidden_[part] && (!isolating_ || isolated_[part]); }
  bool transparent(PartId part) const { return transparent_[part]; }
  bool isolating() const { return isolating_; }
  void setHidden(PartId part, bool hidden) { hidden_[part] = hidden; }
  void setTransparent(PartId part, bool transparent) { transparent_[part] = transparent; }
  /// Shows these parts alone; the same parts again show everything again.
  void isolate(const std::vector<PartId>& parts);
  void showAll();

  document::PartStyle style;  // colours are those of parts that nobody holds

  PartId selected = kNoPart;
  PartId hovered = kNoPart;  // under the mouse, in the part tree or in the scene
  PartId inReach = kNoPart;  // under a mouse that is the hand: a click takes it; kNoPart: the touched part

 private:
  std::vector<bool> hidden_, transparent_, isolated_;
  bool isolating_ = false;
};

/// Computes the look of each part: hidden, a ghost, transparent, coloured, in its owner's colour, touched,
/// selected.
void partLooks(const ViewModel& model, const PartDisplay& display, std::vector<PartLook>& looks);

}  // namespace tandem::client
