#include "client/hand/hand_parts.h"

#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::client {

using haptics::PartCommand;

HandParts::HandParts(const assets::Scene& scene, haptics::TickState& state)
    : state_(state), commands_(scene.parts.size()), followed_(scene), links_(scene.parts.size()) {}

SimulatedHere* HandParts::find(PartId part) {
  for (SimulatedHere& mine : simulated_)
    if (mine.part == part) return &mine;
  return nullptr;
}

bool HandParts::own(PartId part, Epoch epoch, const Pose& worldFromPart) {
  SimulatedHere* entry = find(kNoPart);
  if (entry == nullptr) return false;
  *entry = {.part = part, .epoch = epoch};
  followed_.drop(part);
  commands_.push(PartCommand::Kind::own, part, worldFromPart);
  return true;
}

SimulatedHere& HandParts::coHold(PartId part, sync::Micros sessionNow, bool moving) {
  SimulatedHere* entry = find(kNoPart);
  ASSERT(entry != nullptr);
  *entry = {.part = part, .idleSince = sessionNow};
  Twist twist;
  Pose pose = worldFromPart(part);
  if (FollowedPart* slot = followed_.find(part)) {
    entry->display = slot->display;
    if (moving) {
      pose = slot->display.at(sessionNow);
      twist = slot->twist;
    }
    slot->part = kNoPart;
  } else {
    entry->display.restart(worldFromPart(part), sessionNow);
  }
  commands_.push(PartCommand::Kind::own, part, pose, 0, twist);
  return *entry;
}

void HandParts::leave(SimulatedHere& mine, sync::Micros sessionNow) {
  commands_.push(PartCommand::Kind::disown, mine.part);
  links_.forget(mine.part, state_);
  const SimulatedHere left = std::exchange(mine, {});
  if (FollowedPart* slot = followed_.findOrAdd(left.part, worldFromPart(left.part), sessionNow))
    slot->display = left.display;
}

void HandParts::lose(SimulatedHere& mine, const sync::PartRecord& record, sync::Micros sessionNow) {
  ASSERT(mine.part == record.part);
  commands_.push(PartCommand::Kind::disown, mine.part);
  links_.forget(mine.part, state_);
  mine = {};
  follow(record, sessionNow, isAt(record) ? 0 : kLossBlend);
}

void HandParts::follow(const sync::PartRecord& record, sync::Micros sessionNow, sync::Micros blend) {
  if (FollowedPart* slot = followed_.findOrAdd(record.part, worldFromPart(record.part), sessionNow)) {
    slot->owned = record.owner != kNoSite;
    slot->playOut.restart(record.worldFromPart, sessionNow, blend);
    slot->display.standAt(record.worldFromPart, sessionNow);
  } else {
    commands_.push(PartCommand::Kind::setPose, record.part, record.worldFromPart);
  }
}

void HandParts::onState(const sync::PartState& state, sync::Micros time, sync::Micros sessionNow) {
  if (SimulatedHere* mine = find(state.part)) {
    mine->display.push(state, time);  // a co-holder's hand feels the link instead
  } else if (FollowedPart* slot = followed_.findOrAdd(state.part, worldFromPart(state.part), sessionNow)) {
    slot->playOut.push(state, time);
    slot->display.push(state, time);
  } else {
    commands_.push(PartCommand::Kind::setPose, state.part, state.worldFromPart);
  }
}

bool HandParts::isAt(const sync::PartRecord& record) const {
  const Pose& here = worldFromPart(record.part);
  return glm::length(here.position - record.worldFromPart.position) < kTolerance &&
         glm::length(rotationVector(record.worldFromPart.orientation * glm::conjugate(here.orientation))) <
             kTolerance;
}

}  // namespace tandem::client
