#include "client/hand/grasps.h"

#include <algorithm>

namespace tandem::client {

using haptics::PartCommand;
using Stage = Grasp::Stage;

void Grasps::setButton(std::size_t hand, bool down, PartId target) {
  Grasp& grasp = hands_[hand];
  const Grasp::Button button = grasp.setButton(down);
  if (button == Grasp::Button::pressed && grasp.stage() == Stage::reaching) reach(hand, target);
  if (button == Grasp::Button::lifted && grasp.stage() == Stage::holding) {
    parts_.commands().push(PartCommand::Kind::letGo, grasp.part(), {}, static_cast<std::uint8_t>(hand));
    grasp.end();
  }
}

void Grasps::reach(std::size_t hand, PartId part) {
  if (part >= scene_.parts.size() || !scene_.parts[part].movable) return;
  if (parts_.isReady(part)) return hold(hand, part);  // it still settles here, or the other hand has it
  const Grasp& other = hands_[1 - hand];
  const bool asked = controls_.asked(part) || other.is(Stage::asking, part) || other.is(Stage::taking, part);
  if (asked || intents_.grab(part)) hands_[hand].ask(part);
}

void Grasps::hold(std::size_t hand, PartId part) {
  const bool holds = hands_[hand].hold(part);
  if (SimulatedHere* mine = parts_.find(part)) mine->handled = true;
  if (holds) parts_.commands().push(PartCommand::Kind::grasp, part, {}, static_cast<std::uint8_t>(hand));
}

void Grasps::onGrant(const sync::PartRecord& grant, sync::Micros sessionNow) {
  // For the hand that asked. Where none did, the first hand takes the part, if it is free.
  const bool second = hands_[1].is(Stage::asking, grant.part) && !hands_[0].is(Stage::asking, grant.part);
  Grasp& grasp = hands_[second ? 1 : 0];
  if (grasp.stage() == Stage::taking || grasp.stage() == Stage::holding) {
    // The hand is busy: the part is owned where it is, at rest, and given back.
    static_cast<void>(parts_.own(grant.part, grant.epoch, grant.worldFromPart));
    return;
  }
  parts_.follow(grant, sessionNow, parts_.isAt(grant) ? 0 : kBlend);
  grasp.take(grant, sessionNow + kBlend);
}

void Grasps::advance(std::size_t hand, sync::Micros sessionNow) {
  Grasp& grasp = hands_[hand];
  if (grasp.stage() == Stage::asking && parts_.isReady(grasp.part())) hold(hand, grasp.part());
  if (grasp.stage() != Stage::taking) return;
  const sync::PartRecord& grant = grasp.grant();
  if (!parts_.isAt(grant) && sessionNow < grasp.takingUntil()) return;
  if (!parts_.own(grant.part, grant.epoch, grant.worldFromPart)) return;  // waits until a settling part rests
  hold(hand, grant.part);  // if the button is up by now, the part rests here and is released
}

void Grasps::restart(std::size_t hand) {
  const Grasp& grasp = hands_[hand];
  if (grasp.stage() != Stage::holding) return;
  parts_.commands().push(PartCommand::Kind::letGo, grasp.part(), {}, static_cast<std::uint8_t>(hand));
  parts_.commands().push(PartCommand::Kind::grasp, grasp.part(), {}, static_cast<std::uint8_t>(hand));
}

void Grasps::onSimulated(PartId part) {
  for (std::size_t hand = 0; hand < hands_.size(); ++hand)
    if (hands_[hand].is(Stage::asking, part)) hold(hand, part);
}

void Grasps::onConnectionLost() {
  for (Grasp& grasp : hands_)
    if (grasp.stage() == Stage::asking) grasp.end();
}

bool Grasps::holds(PartId part) const {
  return std::any_of(hands_.begin(), hands_.end(),
                     [&](const Grasp& grasp) { return grasp.is(Stage::holding, part); });
}

bool Grasps::wants(PartId part) const {
  return std::any_of(hands_.begin(), hands_.end(), [&](const Grasp& grasp) {
    return grasp.is(Stage::asking, part) && grasp.buttonIsDown();
  });
}

void Grasps::endAll(Stage stage, PartId part) {
  for (Grasp& grasp : hands_)
    if (grasp.is(stage, part)) grasp.end();
}

}  // namespace tandem::client
