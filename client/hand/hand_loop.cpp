#include "client/hand/hand_loop.h"

#include <algorithm>
#include <optional>

#include <glm/geometric.hpp>

#include "haptics/link/link_distance.h"

namespace tandem::client {

using haptics::PartCommand;

namespace {

// What parts of other sites may change, whatever their owners say: 0.16 N in 20 ms.
constexpr double kForeignSlewLimit = 8.0;  // N/s
constexpr double kFirstFadeTime = 0.25;    // s, of a link to a replica that no hand holds yet

}  // namespace

HandLoop::HandLoop(const haptics::ContactScene& scene, Exchange& exchange)
    : scene_(&scene),
      exchange_(exchange),
      state_(scene),
      intents_(exchange),
      parts_(scene.scene(), state_),
      controls_(scene.scene()),
      grasps_(scene.scene(), parts_, controls_, intents_),
      near_(scene.scene()),
      display_(exchange, state_, scene.scene().parts.size()) {
  wishes_.fill(kNoPart);
}

void HandLoop::setControl(const ControlWish& wish, std::size_t hand) {
  if (wish.count == scriptedWishesSeen_[hand]) return;
  scriptedWishesSeen_[hand] = wish.count;
  controls_.set(wish.part, wish.value);
}

void HandLoop::addSecondHand() { bareTool_ = std::make_unique<BareTool>(*scene_); }

void HandLoop::readSettings() {
  settings_ = exchange_.settings.latest();
  timeBase_ = exchange_.timeBase.latest();
  for (haptics::TickParameters& parameters : settings_.parameters)
    if (parameters.foreignSlewLimit == 0.0) parameters.foreignSlewLimit = kForeignSlewLimit;
  haptics::ContactEffort& effort = settings_.parameters[0].effort;
  effort = effort_.limited(effort);
  if (settings_.faultResets != faultResetsSeen_) {
    faultResetsSeen_ = settings_.faultResets;
    state_.resetFault();
    if (bareTool_) bareTool_->resetFault();
  }
  if (settings_.reseats != reseatsSeen_) {
    reseatsSeen_ = settings_.reseats;
    stalls_.reseat();
  }
  if (settings_.control.count != wishesSeen_) {
    wishesSeen_ = settings_.control.count;
    controls_.set(settings_.control.part, settings_.control.value);
  }
}

Wrench HandLoop::tick(const haptics::DeviceSample& reading, sync::Micros now,
                      const haptics::DeviceSample* second) {
  readSettings();
  const sync::Micros sessionNow = now + timeBase_.offset;
  const bool both = second != nullptr && bareTool_ != nullptr;
  noteStall(now);
  hands_[0].device = afterStall(reading, 0);
  const haptics::DeviceSample& sample = hands_[0].device;
  if (both) hands_[1] = {afterStall(*second, 1), &settings_.parameters[1], {}};
  handleEvents(sessionNow);
  parts_.followed().playOut(sessionNow, timeBase_.playOutDelay, display_);
  for (std::size_t hand = 0; hand < haptics::kHands; ++hand) grasps_.advance(hand, sessionNow);
  askForControls();
  askForNear();
  setButtons(sample, both);

  const std::span<const PartCommand> commands = parts_.commands().nextBatch();
  if (both) hands_[1].tool = feelBareTool(commands, sessionNow);
  const haptics::TickInput input{.hands = hands_,
                                 .moved = parts_.followed().moved(),
                                 .commands = commands,
                                 .sections = sections(),
                                 .sessionTime = static_cast<double>(sessionNow) * 1e-6,
                                 .handCount = both ? 2 : 1,
                                 .lifted = settings_.lifted};
  parts_.links().receive(exchange_, state_);
  output_.tick = haptics::tick(input, *scene_, settings_.parameters[0], state_);
  noteReached();
  parts_.links().update(output_.tick, state_, exchange_);
  if (effort_.stage() > 0) output_.tick.flags |= haptics::kFlagLessEffort;
  if (both) noteSecondHand();
  for (const PartCommand& command : commands) display_.pushAsItIs(command.part, sessionNow);
  releaseRested(sessionNow);
  leaveUntouched(sessionNow);
  publish(sample, now);
  return output_.tick.hands[0].toHand;
}

void HandLoop::setButtons(const haptics::DeviceSample& sample, bool both) {
  const auto target = [this](std::size_t hand, PartId wish, PartId touched) {
    return wishes_[hand] != kNoPart ? wishes_[hand] : wish != kNoPart ? wish : touched;
  };
  const auto pressed = [](const haptics::DeviceSample& of) { return of.valid && (of.buttons & 1u) != 0; };
  // A button that is down when the hands may take parts again has to be pressed anew.
  const auto counts = [this](std::size_t hand, bool down) {
    waitsForLift_[hand] = settings_.lifted || (waitsForLift_[hand] && down);
    return down && !waitsForLift_[hand];
  };
  grasps_.setButton(0, counts(0, settings_.graspButton || pressed(sample)),
                    target(0, settings_.wish, output_.tick.touched));
  if (both)
    grasps_.setButton(1, counts(1, pressed(hands_[1].device)), target(1, kNoPart, bareTool_->touched()));
}

Wrench HandLoop::feelBareTool(std::span<const PartCommand> commands, sync::Micros sessionNow) {
  return bareTool_->tick(hands_[1].device, parts_.followed().moved(), output_.tick, commands,
                         {sections(), settings_.lifted}, settings_.parameters[1],
                         static_cast<double>(sessionNow) * 1e-6, grasps_.isHolding(1));
}

void HandLoop::noteSecondHand() {
  HandRecord& record = output_.hands[1];
  record.device = hands_[1].device;
  const haptics::HandFeedback& felt = output_.tick.hands[1];
  const bool holds = felt.held != kNoPart;
  const std::span<const haptics::Contact> contacts = bareTool_->contacts();
  record.present = true;
  record.worldFromProxy = holds ? Pose{felt.worldFromGrip.position, record.device.worldFromDevice.orientation}
                                : bareTool_->worldFromProxy();
  record.contactCount = holds ? 0 : static_cast<int>(contacts.size());
  std::copy(contacts.begin(), contacts.end(), record.contacts.begin());
  if (bareTool_->fault().raised()) output_.tick.hands[1].flags |= haptics::kFlagFault;
  record.flagsSeen |= output_.tick.hands[1].flags;
  record.maxForce = std::max(record.maxForce, glm::length(output_.tick.hands[1].toHand.force));
  // The tick refuses the grasp of a control that the first hand holds.
  if (grasps_.isHolding(1) && parts_.commands().empty() && output_.tick.hands[1].held == kNoPart)
    grasps_.onRefused(1);
}

void HandLoop::noteStall(sync::Micros now) {
  if (!stalls_.noteTick(now)) return;
  ++output_.stalls;
  state_.noteStall();
  if (bareTool_) bareTool_->noteStall();
}

haptics::DeviceSample HandLoop::afterStall(const haptics::DeviceSample& reading, std::size_t hand) {
  const StallGuard::Reading filtered = stalls_.filter(reading, hand);
  if (filtered.graspsAnew) grasps_.restart(hand);
  return filtered.sample;
}

/// Events stay in their ring while the commands that they may cause would not fit: nothing is lost, only
/// later.
void HandLoop::handleEvents(sync::Micros sessionNow) {
  NetworkEvent event;
  while (parts_.commands().hasRoom() && exchange_.events.pop(event)) handle(event, sessionNow);
}

void HandLoop::handle(const NetworkEvent& event, sync::Micros sessionNow) {
  switch (event.kind) {
    case NetworkEvent::Kind::state:
      return parts_.onState(event.state, event.time, sessionNow);
    case NetworkEvent::Kind::ownership:
      return onOwnership(event.record, sessionNow);
    case NetworkEvent::Kind::denied:
      return onDenial(event.record, sessionNow);
    case NetworkEvent::Kind::link:
      return onLink(event, sessionNow);
    case NetworkEvent::Kind::unlink:
      return state_.endLink(event.link.id);
    case NetworkEvent::Kind::simulators:
      return parts_.links().setSimulators(event.link.id.part, event.simulators);
    case NetworkEvent::Kind::place:
      return controls_.place(event.record.part, event.record.worldFromPart, event.record.epoch);
    case NetworkEvent::Kind::lost:
      return onConnectionLost();
  }
}

void HandLoop::onConnectionLost() {
  intents_.onConnectionLost();
  parts_.followed().forgetRequests();
  grasps_.onConnectionLost();
  controls_.lost();
  for (SimulatedHere& mine : parts_.simulated()) mine.releasing = false;  // asked again once a server answers
}

void HandLoop::onOwnership(const sync::PartRecord& record, sync::Micros sessionNow) {
  SimulatedHere* mine = parts_.find(record.part);
  if (record.owner == timeBase_.self && timeBase_.self != kNoSite) {
    if (mine) {  // reclaimed after an outage, or passed on by the owner to its co-holder
      mine->releasing = mine->releasing && mine->epoch == record.epoch;
      mine->epoch = record.epoch;
    } else if (!ownControl(record)) {
      grasps_.onGrant(record, sessionNow);
    }
    return;
  }
  if (!mine) {
    noteOwner(record);
    return parts_.follow(record, sessionNow, Grasps::kBlend);
  }
  const bool canBeShared =
      record.owner != kNoSite && assets::controlOf(scene_->scene(), record.part) == nullptr;
  if (canBeShared && mine->coHeld()) return;  // the link to the new owner follows
  if (canBeShared && grasps_.holds(record.part) && intents_.grab(record.part)) {
    mine->epoch = 0;
    mine->releasing = false;
    return;
  }
  lose(*mine, record, sessionNow);
}

/// A part that another site owns is no longer taken by a hand here.
void HandLoop::noteOwner(const sync::PartRecord& record) {
  if (record.owner != timeBase_.self) grasps_.onOtherOwner(record.part);
}

void HandLoop::lose(SimulatedHere& mine, const sync::PartRecord& record, sync::Micros sessionNow) {
  grasps_.onLostPart(record.part);
  if (!mine.releasing) controls_.denied(record.part);  // taken away, not given back
  noteOwner(record);
  parts_.lose(mine, record, sessionNow);
}

void HandLoop::onDenial(const sync::PartRecord& record, sync::Micros sessionNow) {
  grasps_.onDenial(record.part);
  controls_.denied(record.part);
  SimulatedHere* mine = parts_.find(record.part);
  if (mine && mine->coHeld()) lose(*mine, record, sessionNow);
}

void HandLoop::onLink(const NetworkEvent& order, sync::Micros sessionNow) {
  const PartId part = order.link.id.part;
  haptics::LinkTerms terms = order.link;
  terms.firstFadeTime = kFirstFadeTime;
  if (settings_.believesPeers) terms.parameters.peerSlew = 0.0;
  if (!order.ownedByPeer) return state_.orderLink(terms);
  const SimulatedHere* mine = parts_.find(part);
  const bool carried =
      haptics::regimeAt(terms.delay, haptics::longestDelay(true)) != haptics::LinkRegime::apart;
  const bool takes = !mine && carried && grasps_.wants(part);
  if (!mine) mine = joinAsCoHolder(part, takes, sessionNow);
  if (!mine) {  // the hand that asked has let go since: it may ask again
    static_cast<void>(intents_.leave(part));
    return grasps_.onDenial(part);
  }
  terms.outageSpring = takes || !mine->handled;
  if (!takes) terms.firstFadeTime = 0.0;
  terms.parameters.longestDelay = haptics::longestDelay(mine->handled);
  state_.orderLink(terms);
}

/// Simulates another site's part, which a hand here `takes` as it moves, or which comes near; null if nothing
/// here wants that any more.
SimulatedHere* HandLoop::joinAsCoHolder(PartId part, bool takes, sync::Micros sessionNow) {
  const FollowedPart* slot = parts_.followed().find(part);
  const bool wanted = controls_.asked(part) || (slot != nullptr && slot->asked) || grasps_.wants(part);
  if (!wanted || !parts_.hasRoom()) return nullptr;
  SimulatedHere& mine = parts_.coHold(part, sessionNow, takes);
  static_cast<void>(controls_.granted(part));
  grasps_.onSimulated(part);
  return &mine;
}

/// Notes which of the parts here are held, or near such a part through others here: what they meet comes to
/// be felt by the hand. A push that ended in a part that is only played out would be met by a wall.
void HandLoop::noteReached() {
  std::array<SimulatedHere, haptics::kMaxOwnedParts>& parts = parts_.simulated();
  for (SimulatedHere& mine : parts) {
    const haptics::OwnedPart* part = mine.part != kNoPart ? output_.tick.simulated(mine.part) : nullptr;
    mine.reached = part != nullptr && part->held;
  }
  if (std::none_of(parts.begin(), parts.end(), [](const SimulatedHere& mine) { return mine.reached; }))
    return;
  const auto near = [this](const SimulatedHere& reached, const SimulatedHere& mine) {
    return reached.reached && reached.part != mine.part &&
           near_.meet(simulatedAt(reached.part), simulatedAt(mine.part),
                      sync::toSeconds(timeBase_.playOutDelay), NearParts::kStillNear);
  };
  for (bool grows = true; grows;) {
    grows = false;
    for (SimulatedHere& mine : parts) {
      if (mine.part == kNoPart || mine.reached) continue;
      mine.reached = std::any_of(parts.begin(), parts.end(),
                                 [&](const SimulatedHere& other) { return near(other, mine); });
      grows = grows || mine.reached;
    }
  }
}

/// Whether a part comes near to one that is reached here and that does not pass through others.
bool HandLoop::meetsReached(const NearParts::Moving& other, double near) {
  if (output_.tick.flags & haptics::kFlagHeldWithoutContact) return false;
  const double playOutDelay = sync::toSeconds(timeBase_.playOutDelay);
  const auto& parts = parts_.simulated();
  return std::any_of(parts.begin(), parts.end(), [&](const SimulatedHere& mine) {
    return mine.reached && mine.part != other.part &&
           near_.meet(simulatedAt(mine.part), other, playOutDelay, near);
  });
}

/// Asks to co-hold what a reached part may soon touch.
void HandLoop::askForNear() {
  for (const haptics::PartMotion& moved : parts_.followed().moved()) {
    FollowedPart* slot = parts_.followed().find(moved.part);
    if (!slot || !slot->owned || slot->control != nullptr) continue;
    const bool meets = meetsReached({moved.part, moved.worldFromPart, moved.twist},
                                    slot->asked ? NearParts::kStillNear : NearParts::kNear);
    if (meets && !slot->asked) slot->asked = intents_.grab(slot->part);
    if (!meets) slot->asked = false;
  }
}

NearParts::Moving HandLoop::simulatedAt(PartId part) const {
  const haptics::OwnedPart* mine = output_.tick.simulated(part);
  return mine != nullptr ? NearParts::Moving{part, mine->worldFromPart, mine->twist}
                         : NearParts::Moving{part, state_.worldFromPart(part), {}};
}

/// A co-held part that nothing here touches is left to its owner.
void HandLoop::leaveUntouched(sync::Micros sessionNow) {
  for (SimulatedHere& mine : parts_.simulated()) {
    if (mine.part == kNoPart || !mine.coHeld()) continue;
    if (grasps_.holds(mine.part) || meetsReached(simulatedAt(mine.part), NearParts::kStillNear))
      mine.idleSince = sessionNow;
    if (sessionNow - mine.idleSince < kCoHolderStays) continue;
    if (intents_.leave(mine.part)) parts_.leave(mine, sessionNow);
  }
}

/// One part a tick: what the tool presses on, or what is to be set.
void HandLoop::askForControls() {
  const auto owned = [this](PartId part) { return parts_.find(part) != nullptr; };
  const PartId part = controls_.wanted(output_.tick, owned);
  if (part != kNoPart && !intents_.grab(part)) controls_.askLater(part);
  const std::optional<PartId> set = controls_.toSet(owned);
  if (!set || output_.tick.hands[0].held == *set || output_.tick.hands[1].held == *set ||
      !parts_.isReady(*set))
    return;
  if (const std::optional<Pose> pose = controls_.granted(*set)) {
    parts_.commands().push(PartCommand::Kind::disown, *set);
    parts_.commands().push(PartCommand::Kind::own, *set, *pose);
  }
}

/// A control that this hand asked for is owned where it is here, without a grasp: the tool rests on it, and
/// must not be moved by a pose that comes from elsewhere.
bool HandLoop::ownControl(const sync::PartRecord& record) {
  if (!controls_.asked(record.part) || !parts_.hasRoom()) return false;
  const std::optional<Pose> set = controls_.granted(record.part, record.epoch);
  static_cast<void>(parts_.own(record.part, record.epoch, set.value_or(state_.worldFromPart(record.part))));
  grasps_.onSimulated(record.part);  // the button went down on it meanwhile
  return true;
}

void HandLoop::releaseRested(sync::Micros sessionNow) {
  for (int i = 0; i < output_.tick.ownedCount; ++i) {
    const haptics::OwnedPart& part = output_.tick.owned[static_cast<std::size_t>(i)];
    SimulatedHere* mine = parts_.find(part.part);
    const bool coHeld = mine && mine->coHeld() && !mine->releasing;
    display_.push({part.part, true, sessionNow, part.worldFromPart,
                   coHeld ? mine->display.at(sessionNow) : part.worldFromPart});
    if (!mine || mine->coHeld() || mine->releasing || part.held) continue;
    // A part with co-holders is left to them, at rest or not.
    if (!part.atRest && parts_.links().simulators(part.part) == 1) continue;
    mine->releasing = intents_.push({HandIntent::Kind::release, part.part, mine->epoch, part.worldFromPart});
  }
}

void HandLoop::publish(const haptics::DeviceSample& sample, sync::Micros now) {
  output_.time = now;
  HandRecord& record = output_.hands[0];
  record.device = sample;
  record.flagsSeen |= output_.tick.flags;
  record.maxForce = std::max(record.maxForce, glm::length(output_.tick.hands[0].toHand.force));
  // The flag lasts for one tick, which is too short to be seen.
  constexpr sync::Micros kShown = sync::kSecond;
  if (output_.tick.flags & haptics::kFlagPopThrough) poppedThroughUntil_ = now + kShown;
  output_.poppedThrough = now < poppedThroughUntil_;
  output_.fault = state_.fault().condition;
  output_.grabPending = grasps_.isPending();
  for (int i = 0; i < output_.tick.ownedCount; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const SimulatedHere* mine = parts_.find(output_.tick.owned[index].part);
    // From its release on the part may be another site's, though this site does not know yet.
    output_.ownedEpoch[index] = mine && !mine->releasing ? mine->epoch : 0;
  }
  exchange_.output.write(output_);
  exchange_.view.write(output_);
  // A full ring means a plot that nobody draws.
  static_cast<void>(
      exchange_.forces.push(static_cast<float>(glm::length(output_.tick.hands[0].toHand.force))));
  display_.refreshOne();
}

}  // namespace tandem::client
