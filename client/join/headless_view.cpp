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
      style_.explode = step.style.explode;
      style_.apart = step.style.apart;
      break;
    case Verb::colour:
      style_.colouring = step.style.colouring;
      break;
    case Verb::ghosts:
      style_.ghosts = step.style.ghosts;
      break;
    case Verb::select:
      selected_ = step.part;
      break;
    case Verb::look:
      camera_ = cameraFrom(step.from, step.vector, camera_);
      break;
    case Verb::point:
      pointAt(step.part, model);
      break;
    case Verb::say:
      says_.push_back(saidWithLinks(step.text, *model.scene));
      break;
    default:
      break;
  }
}

void HeadlessView::pointAt(PartId part, const ViewModel& model) {
  shown_.pointedAt = part;
  if (part == kNoPart) return;
  const Pose& worldFromPart = model.worldFromPart[part];
  const glm::dvec3 world =
      nearestSurfacePoint(*model.scene, part, worldFromPart, model.hand.worldFromProxy.position).point;
  shown_.place = transformPoint(inverse(worldFromPart), world);
}

const std::vector<document::SectionPlane>& HeadlessView::sections(const ViewModel& model) const {
  return following_.followsSections() ? model.presenting.shared.sections : sections_;
}

const document::PartStyle& HeadlessView::style(const ViewModel&) const { return style_; }

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
  shareView(shown_, actions.sections, selected_, model.worldFromPart.size(),
            [&](PartId part) { return std::find(hidden_.begin(), hidden_.end(), part) != hidden_.end(); });
  actions.shown = shown_;
  return actions;
}

}  // namespace tandem::client
