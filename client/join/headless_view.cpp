#include "client/join/headless_view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include "client/session/said_parts.h"

namespace tandem::client {

using Verb = ScriptStep::Verb;
using sync::Shares;

Camera cameraFrom(const glm::dvec3& from, const glm::dvec3& to, const Camera& like) {
  Camera camera = like;
  camera.target = to;
  camera.distance = glm::length(from - to);
  const glm::dvec3 back = (from - to) / camera.distance;
  camera.pitch = std::asin(std::clamp(back.y, -1.0, 1.0));
  camera.yaw = std::atan2(back.x, back.z);
  return camera;
}

void HeadlessView::perform(const ScriptStep& step, const ViewModel& model) {
  switch (step.verb) {
    case Verb::section:
      sections_ = step.planes;
      break;
    case Verb::share:
      shown_.shares = step.shares;
      break;
    case Verb::follow:
      following_.followLater(step.shares != Shares::nothing);
      break;
    case Verb::hide:
      hidden_ = step.parts;
      break;
    case Verb::explode:
    case Verb::colour:
    case Verb::ghosts:
      changeStyle(step, style_);
      break;
    case Verb::select:
      selected_ = step.part;
      break;
    case Verb::inspect:
      inspection_ = step.inspection;
      break;
    case Verb::look:
      camera_ = cameraFrom(step.from, step.vector, camera_);
      break;
    case Verb::point: {
      const document::Anchor place = nearestToHand(step.part, model);
      shown_.pointedAt = place.part;
      shown_.place = place.point;
      break;
    }
    case Verb::say:
      says_.push_back(saidWithLinks(step.text, *model.scene));
      break;
    default:
      break;
  }
}

void changeStyle(const ScriptStep& step, document::PartStyle& style) {
  if (step.verb == Verb::explode) {
    style.explode = step.style.explode;
    style.apart = step.style.apart;
  }
  if (step.verb == Verb::colour) style.colouring = step.style.colouring;
  if (step.verb == Verb::ghosts) style.ghosts = step.style.ghosts;
}

document::Anchor nearestToHand(PartId part, const ViewModel& model) {
  if (part == kNoPart) return {};
  const Pose& worldFromPart = model.worldFromPart[part];
  const glm::dvec3 world =
      nearestSurfacePoint(*model.scene, part, worldFromPart, model.hand.worldFromProxy.position).point;
  return {part, transformPoint(inverse(worldFromPart), world)};
}

const std::vector<document::SectionPlane>& HeadlessView::sections(const ViewModel& model) const {
  return following_.followsSections() ? model.presenting.shared.sections : sections_;
}

const document::PartStyle& HeadlessView::style(const ViewModel& model) const {
  return following_.followsView() ? model.presenting.shared.style : style_;
}

void HeadlessView::keepIn(document::NamedView& view, const ViewModel& model) const {
  view.sections = sections(model);
  view.style = style(model);
  view.parts = hidden_;
  if (!following_.followsView()) return;
  view.seenThrough = seenThroughOf(model.worldFromPart.size(),
                                   [&](PartId part) { return model.presenting.seesThrough(part); });
  view.parts.clear();
  for (std::size_t part = 0; part < model.worldFromPart.size() && view.parts.size() < document::kMaxListed;
       ++part)
    if (model.presenting.hides(static_cast<PartId>(part))) view.parts.push_back(static_cast<PartId>(part));
}

ViewActions HeadlessView::act(const ViewModel& model) {
  if (std::exchange(ended_, model.presenting.ended) != model.presenting.ended)
    shown_.shares = Shares::nothing;
  following_.update(model.presenting, shown_.shares);
  ViewActions actions;
  actions.settings = model.settings;
  actions.worldFromCamera = worldFromCamera(camera_);
  actions.sections = sections(model);
  actions.lifted = style(model).explode > 0.0;
  actions.says = std::exchange(says_, {});
  const auto hides = [&](PartId part) {
    return std::find(hidden_.begin(), hidden_.end(), part) != hidden_.end();
  };
  const auto seesThrough = [](PartId) { return false; };
  shareView(shown_, actions.sections,
            SeenParts<decltype(hides), decltype(seesThrough)>{model.worldFromPart.size(), selected_,
                                                              style(model), inspection_, hides, seesThrough});
  actions.shown = shown_;
  return actions;
}

}  // namespace tandem::client
