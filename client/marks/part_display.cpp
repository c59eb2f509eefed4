#include "client/marks/part_display.h"

#include <algorithm>

#include "assets/base/assert.h"
#include "client/picture/colours.h"

namespace tandem::client {
namespace {

constexpr float kTransparentAlpha = 0.28f, kGhostAlpha = 0.07f;
constexpr float kColouredTint = 0.8f;
constexpr glm::vec3 kSelection(0.95f, 0.55f, 0.05f);  // sRGB; not one of the sites' colours
constexpr glm::vec3 kHover(0.25f, 0.30f, 0.38f);

void markOwned(PartLook& look, const glm::vec3& colour, bool heldHere) {
  look.tint = linear(colour);
  look.tintAmount = heldHere ? 0.75f : 0.6f;
  look.rimAmount = 0.7f;
  look.edgeColour = 0.72f * colour;
  look.edgeWidth = heldHere ? 2.2f : 1.6f;
}

void colour(const ViewModel& model, PartId part, PartColouring colouring, PartLook& look) {
  if (model.scene == nullptr || colouring == PartColouring::asMade) return;
  look.tint = linear(*client::colourOf(*model.scene, part, colouring));
  look.tintAmount = kColouredTint;
}

/// Hides the parts that a layer of the scene hides: the hand does not feel them either.
void hideLayers(const ViewModel& model, std::vector<PartLook>& looks) {
  if (model.scene == nullptr) return;
  for (const assets::Control& layer : model.scene->controls) {
    if (layer.kind != assets::ControlKind::layer || layer.part >= model.worldFromPart.size()) continue;
    if (assets::isShowing(layer, assets::controlValue(layer, model.worldFromPart[layer.part]))) continue;
    for (const PartId part : layer.shows)
      if (part < looks.size()) looks[part].visible = false;
  }
}

}  // namespace

void PartDisplay::isolate(const std::vector<PartId>& parts) {
  std::vector<bool> wanted(isolated_.size(), false);
  for (const PartId part : parts) {
    ASSERT(part < wanted.size());
    wanted[part] = true;
  }
  if (isolating_ && wanted == isolated_) {
    isolating_ = false;
    return;
  }
  isolated_ = std::move(wanted);
  isolating_ = true;
  for (const PartId part : parts) hidden_[part] = false;
}

void PartDisplay::showAll() {
  std::fill(hidden_.begin(), hidden_.end(), false);
  std::fill(transparent_.begin(), transparent_.end(), false);
  isolating_ = false;
}

void partLooks(const ViewModel& model, const PartDisplay& display, std::vector<PartLook>& looks) {
  ASSERT(display.partCount() == model.worldFromPart.size());
  looks.assign(model.worldFromPart.size(), PartLook{});
  const PartId inReach = display.inReach != kNoPart ? display.inReach : model.hand.touched;
  for (std::size_t p = 0; p < looks.size(); ++p) {
    const auto part = static_cast<PartId>(p);
    PartLook& look = looks[p];
    look.visible = display.visible(part) || display.style.ghosts;
    look.pickable = display.visible(part);
    if (display.transparent(part)) look.alpha = kTransparentAlpha;
    if (!look.pickable) look.alpha = kGhostAlpha;
    colour(model, part, display.style.colouring, look);
    const SiteId owner = p < model.owner.size() ? model.owner[p] : kNoSite;
    const bool held = part == model.hand.held;
    if (held) {
      markOwned(look, selfColour(model), true);
    } else if (const SiteView* site = owner != kNoSite ? findSite(model, owner) : nullptr) {
      markOwned(look, srgb(site->info.colour), false);
    }
    if (part == inReach && !held) {
      if (look.edgeWidth <= 0.0f) look.edgeColour = 0.85f * selfColour(model);
      look.edgeWidth = std::max(look.edgeWidth, 1.8f);
    }
    if (part == display.hovered && look.edgeWidth <= 0.0f) {
      look.edgeColour = kHover;
      look.edgeWidth = 1.6f;
    }
    if (part == display.selected) {
      if (look.tintAmount <= 0.0f) {
        look.tint = linear(kSelection);
        look.tintAmount = 0.12f;
        look.rimAmount = 0.8f;
      }
      look.edgeColour = kSelection;
      look.edgeWidth = 2.2f;
    }
  }
  hideLayers(model, looks);
}

}  // namespace tandem::client
