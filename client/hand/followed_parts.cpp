#include "client/hand/followed_parts.h"

namespace tandem::client {
namespace {

/// Play-out knows nothing of the axis and the stops of a control, neither between two states nor beyond the
/// last.
void keepToStops(const assets::Control& control, sync::PlayOut::Shown& shown) {
  const double value = assets::controlValue(control, shown.worldFromPart);
  const double possible = assets::admissible(control, value);
  if (possible != value) shown.twist = {};
  shown.worldFromPart = assets::poseAt(control, possible);
}

}  // namespace

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
  return slot;
}

void FollowedParts::drop(PartId part) {
  if (FollowedPart* slot = find(part)) slot->part = kNoPart;
}

void FollowedParts::forgetRequests() {
  for (FollowedPart& slot : slots_) slot.asked = false;
}

void FollowedParts::playOut(sync::Micros sessionNow, sync::Micros playOutDelay, DisplayPoses& display) {
  moved_.clear();
  for (FollowedPart& slot : slots_) {
    if (slot.part == kNoPart) continue;
    sync::PlayOut::Shown shown = slot.playOut.at(sessionNow, playOutDelay);
    if (slot.control != nullptr) keepToStops(*slot.control, shown);
    slot.twist = shown.still ? Twist{} : shown.twist;
    moved_.push_back({slot.part, shown.worldFromPart, slot.twist});
    const Pose drawn = slot.control != nullptr ? shown.worldFromPart : slot.display.at(sessionNow);
    // The last display pose stays on the screen, so it must be where the part is.
    const bool over = !slot.owned && shown.still && sync::PosePrediction::near(drawn, shown.worldFromPart);
    display.push({slot.part, false, sessionNow - playOutDelay, shown.worldFromPart,
                  over ? shown.worldFromPart : drawn});
    if (over) slot.part = kNoPart;
  }
}

}  // namespace tandem::client
