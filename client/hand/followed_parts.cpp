#include "client/hand/followed_parts.h"

#include <algorithm>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "client/hand/near_parts.h"

namespace tandem::client {
namespace {

constexpr sync::Micros kClockStep = 10 * sync::kMillisecond;

/// Play-out knows nothing of the axis and the stops of a control, neither between two states nor beyond the
/// last.
void keepToStops(const assets::Control& control, sync::PlayOut::Shown& shown) {
  const double value = assets::controlValue(control, shown.worldFromPart);
  const double possible = assets::admissible(control, value);
  if (possible != value) shown.twist = {};
  shown.worldFromPart = assets::poseAt(control, possible);
}

}  // namespace

FollowedParts::FollowedParts(const assets::Scene& scene)
    : scene_(scene), distrustedUntil_(scene.parts.size(), 0) {
  radii_.reserve(scene.parts.size());
  for (const assets::Part& part : scene.parts) {
    const assets::Bounds box = boxOf(scene, part);
    radii_.push_back(glm::length(glm::max(glm::abs(box.min), glm::abs(box.max))));
  }
}

FollowedPart* FollowedParts::find(PartId part) {
  for (FollowedPart& slot : slots_)
    if (slot.part == part) return &slot;
  return nullptr;
}

FollowedPart* FollowedParts::findOrAdd(PartId part, const Pose& worldFromPart, sync::Micros sessionNow) {
  if (FollowedPart* slot = find(part)) return slot;
  FollowedPart* slot = find(kNoPart);
  if (slot == nullptr) return nullptr;
  slot->part = part;
  slot->owned = true;
  slot->asked = false;
  slot->twist = {};
  slot->control = assets::controlOf(scene_, part);
  slot->playOut.restart(worldFromPart, sessionNow, 0);
  slot->display.restart(worldFromPart, sessionNow);
  slot->trust = {scene_.parts[part].massProperties.mass, radii_[part], worldFromPart};
  return slot;
}

void FollowedParts::drop(PartId part) {
  if (FollowedPart* slot = find(part)) slot->part = kNoPart;
}

void FollowedParts::forgetRequests() {
  for (FollowedPart& slot : slots_) slot.asked = false;
}

void FollowedParts::distrust(PartId part, sync::Micros until) {
  distrustedUntil_[part] = std::max(distrustedUntil_[part], until);
}

void FollowedParts::playOut(sync::Micros sessionNow, sync::Micros elapsed, sync::Micros playOutDelay,
                            DisplayPoses& display) {
  moved_.clear();
  impossible_ = kNoPart;
  // The session's clock may be put forward a little, which moves everything.
  const double sinceLast =
      sync::toSeconds(elapsed + std::clamp<sync::Micros>(sessionNow - playedAt_ - elapsed, 0, kClockStep));
  playedAt_ = sessionNow;
  for (FollowedPart& slot : slots_) {
    if (slot.part == kNoPart) continue;
    sync::PlayOut::Shown shown = slot.playOut.at(sessionNow, playOutDelay);
    if (slot.control != nullptr) keepToStops(*slot.control, shown);
    const bool suspect =
        slot.trust.advance(shown.worldFromPart, sinceLast) || sessionNow < distrustedUntil_[slot.part];
    if (slot.owned && slot.trust.impossible()) impossible_ = slot.part;
    slot.twist = shown.still ? Twist{} : shown.twist;
    moved_.push_back({slot.part, shown.worldFromPart, slot.twist, suspect});
    const Pose drawn = slot.control != nullptr ? shown.worldFromPart : slot.display.at(sessionNow);
    // The last display pose stays on the screen, so it must be where the part is.
    const bool over = !slot.owned && shown.still && sync::PosePrediction::near(drawn, shown.worldFromPart);
    display.push({slot.part, false, sessionNow - playOutDelay, shown.worldFromPart,
                  over ? shown.worldFromPart : drawn});
    if (over) slot.part = kNoPart;
  }
}

}  // namespace tandem::client
