#include "client/hand/hand_loop.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

namespace tandem::client {

using haptics::PartCommand;

namespace {

bool near(const Pose& a, const Pose& b, double tolerance) {
  return glm::length(a.position - b.position) < tolerance &&
         glm::length(rotationVector(b.orientation * glm::conjugate(a.orientation))) < tolerance;
}

}  // namespace

HandLoop::HandLoop(const haptics::ContactScene& scene, Exchange& exchange)
    : scene_(scene),
      exchange_(exchange),
      state_(scene),
      links_(scene.scene().parts.size()),
      near_(scene.scene()),
      commands_(2 * scene.scene().parts.size() + 64),
      controls_(scene.scene()) {}

void HandLoop::setControl(const ControlWish& wish, std::size_t hand) {
  if (wish.count == scriptedWishesSeen_[hand]) return;
  scriptedWishesSeen_[hand] = wish.count;
  controls_.set(wish.part, wish.value);
}

void HandLoop::addSecondHand() { secondTool_ = std::make_unique<SecondTool>(scene_); }

void HandLoop::readSettings() {
  settings_ = exchange_.settings.latest();
  timeBase_ = exchange_.timeBase.latest();
  settings_.parameters.effort = effort_.limited(settings_.parameters.effort);
  if (settings_.faultResets != faultResetsSeen_) {
    faultResetsSeen_ = settings_.faultResets;
    state_.resetFault();
    if (secondTool_) secondTool_->resetFault();
  }
  if (settings_.reseats != reseatsSeen_) {
    reseatsSeen_ = settings_.reseats;
    reseatTicks_ = kReseatTicks;
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
  const bool stalled = noteStall(now), both = second != nullptr && secondTool_ != nullptr;
  const haptics::DeviceSample sample = afterStall(reading, stalled, 0);
  if (both) second_ = {afterStall(*second, stalled, 1), &settings_.second, {}};
  takeEvents(sessionNow);
  playOutFollowed(sessionNow);
  for (std::uint8_t hand = 0; hand < haptics::kHands; ++hand) finishTaking(hand, sessionNow);
  askForControls();
  askForNear();
  followGrasp(settings_.graspButton || (sample.valid && (sample.buttons & 1u) != 0), 0, output_.tick.touched);
  if (both)
    followGrasp(second_.device.valid && (second_.device.buttons & 1u) != 0, 1, secondTool_->touched());

  std::size_t batch = 0;
  for (; batch < haptics::kMaxPartCommands && commandCount_ > 0; ++batch, --commandCount_) {
    commandBatch_[batch] = commands_[commandHead_];
    commandHead_ = (commandHead_ + 1) % commands_.size();
  }
  if (both) second_.tool = feelSecondTool(batch, sessionNow);
  const haptics::TickInput input{sample,
                                 {moved_.data(), movedCount_},
                                 {commandBatch_.data(), batch},
                                 static_cast<double>(sessionNow) * 1e-6,
                                 both ? &second_ : nullptr};
  links_.receive(exchange_, state_);
  output_.tick = haptics::tick(input, scene_, settings_.parameters, state_);
  links_.update(output_.tick, state_, exchange_);
  if (effort_.stage() > 0) output_.tick.flags |= haptics::kFlagLessEffort;
  if (both) noteSecond();
  for (std::size_t i = 0; i < batch; ++i) showAsItIs(commandBatch_[i].part, sessionNow);
  releaseRested(sessionNow);
  leaveUntouched(sessionNow);
  publish(sample, now);
  return output_.tick.toHand;
}

Wrench HandLoop::feelSecondTool(std::size_t batch, sync::Micros sessionNow) {
  return secondTool_->tick(second_.device, {moved_.data(), movedCount_}, output_.tick,
                           {commandBatch_.data(), batch}, settings_.second,
                           static_cast<double>(sessionNow) * 1e-6, grasps_[1].stage == Stage::holding);
}

void HandLoop::noteSecond() {
  output_.second = second_.device;
  if (secondTool_->fault().raised()) output_.tick.second.flags |= haptics::kFlagFault;
  output_.secondFlagsSeen |= output_.tick.second.flags;
  output_.secondMost = std::max(output_.secondMost, glm::length(output_.tick.second.toHand.force));
  // A grasp that the tick refused: the first hand holds that control.
  if (grasps_[1].stage == Stage::holding && commandCount_ == 0 && output_.tick.second.held == kNoPart)
    grasps_[1].stage = Stage::idle;
}

bool HandLoop::noteStall(sync::Micros now) {
  const bool stalled = lastTick_ != 0 && now - lastTick_ > kStall;
  lastTick_ = now;
  if (!stalled) return false;
  ++output_.stalls;
  state_.noteStall();
  if (secondTool_) secondTool_->noteStall();
  return true;
}

/// A loop that stood still has lost its hold on the world: the hands are elsewhere, and the devices' own watchdogs have
/// let go. One tick without a reading sets the force to zero; then the held part is grasped anew where both now are, and
/// the tick puts the tool onto a hand that has gone on: it may be inside of anything.
haptics::DeviceSample HandLoop::afterStall(haptics::DeviceSample sample, bool stalled, std::uint8_t hand) {
  if (hand == 0 && reseatTicks_ > 0) {
    --reseatTicks_;
    sample.valid = false;
  }
  if (stalled) {
    sample.valid = false;
    graspAnew_[hand] = true;
  } else if (graspAnew_[hand] && sample.valid) {
    graspAnew_[hand] = false;
    if (grasps_[hand].stage == Stage::holding) {
      command(PartCommand::Kind::letGo, grasps_[hand].part, {}, hand);
      command(PartCommand::Kind::grasp, grasps_[hand].part, {}, hand);
    }
  }
  return sample;
}

void HandLoop::takeEvents(sync::Micros sessionNow) {
  NetworkEvent event;
  // Events stay in their ring while the commands that they may cause would not fit: nothing is lost, only
  // later.
  while (commandCount_ + haptics::kMaxPartCommands < commands_.size() && exchange_.events.pop(event)) {
    switch (event.kind) {
      case NetworkEvent::Kind::state:
        takeState(event.state, event.time, sessionNow);
        break;
      case NetworkEvent::Kind::ownership:
        takeOwnership(event.record, sessionNow);
        break;
      case NetworkEvent::Kind::denied:
        takeDenial(event.record, sessionNow);
        break;
      case NetworkEvent::Kind::link:
        takeLink(event, sessionNow);
        break;
      case NetworkEvent::Kind::unlink:
        state_.endLink(event.link.id);
        break;
      case NetworkEvent::Kind::simulators:
        links_.setSimulators(event.link.id.part, event.simulators);
        break;
      case NetworkEvent::Kind::lost:
        ++lost_;
        for (Followed& slot : followed_) slot.asked = false;
        for (Grasp& grasp : grasps_)
          if (grasp.stage == Stage::asked) grasp.stage = Stage::idle;
        controls_.lost();
        for (Owned& owned : owned_) owned.releasing = false;  // asked again once there is a server again
        break;
    }
  }
}

void HandLoop::takeState(const sync::PartState& state, sync::Micros time, sync::Micros sessionNow) {
  if (Owned* mine = ownedEntry(state.part)) {
    mine->seen.push(state, time);  // to a guest's hand the tie says more
  } else if (Followed* slot = slotFor(state.part, sessionNow)) {
    slot->playOut.push(state, time);
    slot->seen.push(state, time);
  } else {
    command(PartCommand::Kind::setPose, state.part, state.worldFromPart);
  }
}

void HandLoop::takeOwnership(const sync::PartRecord& record, sync::Micros sessionNow) {
  Owned* mine = ownedEntry(record.part);
  if (record.owner == timeBase_.self && timeBase_.self != kNoSite) {
    if (mine) {  // reclaimed after an outage, or passed on by the owner that it was shared with
      mine->releasing = mine->releasing && mine->epoch == record.epoch;
      mine->epoch = record.epoch;
    } else if (!takeControl(record)) {
      beginTaking(record, sessionNow);
    }
    return;
  }
  if (!mine) return follow(record, sessionNow, kBlend);
  const bool shared = record.owner != kNoSite && assets::controlOf(scene_.scene(), record.part) == nullptr;
  if (shared && mine->coHeld()) return;  // the new owner's tie follows
  if (shared && isHeld(record.part) && ask({HandIntent::Kind::grab, record.part, 0, {}})) {
    mine->epoch = 0;
    mine->releasing = false;
    return;
  }
  loseOwned(*mine, record, sessionNow);
}

bool HandLoop::isHeld(PartId part) const {
  return std::any_of(grasps_.begin(), grasps_.end(),
                     [&](const Grasp& grasp) { return grasp.has(Stage::holding, part); });
}

void HandLoop::stopAsking(PartId part) {
  for (Grasp& grasp : grasps_)
    if (grasp.has(Stage::asked, part)) grasp.stage = Stage::idle;
}

void HandLoop::takeDenial(const sync::PartRecord& record, sync::Micros sessionNow) {
  stopAsking(record.part);
  controls_.denied(record.part);
  Owned* mine = ownedEntry(record.part);
  if (mine && mine->coHeld()) loseOwned(*mine, record, sessionNow);
}

void HandLoop::takeLink(const NetworkEvent& order, sync::Micros sessionNow) {
  const PartId part = order.link.id.part;
  if (!order.ownedByPeer) return state_.orderLink(order.link);
  const Owned* mine = ownedEntry(part);
  if (!mine) mine = joinAsCoHolder(part, sessionNow);
  if (!mine) {  // the hand that asked has let go since: it may ask again
    ask({HandIntent::Kind::leave, part, 0, {}});
    return stopAsking(part);
  }
  haptics::LinkTerms terms = order.link;
  terms.outageSpring = !mine->handled;
  terms.parameters.longestDelay = haptics::longestDelay(mine->handled);
  state_.orderLink(terms);
}

/// Whether a part that others move comes near to one that a hand here holds and that does not pass through others.
bool HandLoop::meetsHeld(const NearParts::Moving& other, double near) const {
  if (output_.tick.flags & haptics::kFlagHeldWithoutContact) return false;
  for (int i = 0; i < output_.tick.ownedCount; ++i) {
    const haptics::OwnedPart& mine = output_.tick.owned[static_cast<std::size_t>(i)];
    if (!mine.held || mine.part == other.part) continue;
    if (near_.meet({mine.part, mine.worldFromPart, mine.twist}, other,
                   sync::toSeconds(timeBase_.playOutDelay), near))
      return true;
  }
  return false;
}

/// To share what may soon be touched with what is held here.
void HandLoop::askForNear() {
  for (std::size_t i = 0; i < movedCount_; ++i) {
    Followed* slot = slotOf(moved_[i].part);
    if (!slot || !slot->owned || slot->control != nullptr) continue;
    const bool meets = meetsHeld({moved_[i].part, moved_[i].worldFromPart, moved_[i].twist},
                                 slot->asked ? NearParts::kStillNear : NearParts::kNear);
    if (meets && !slot->asked) slot->asked = ask({HandIntent::Kind::grab, slot->part, 0, {}});
    if (!meets) slot->asked = false;
  }
}

/// Simulates another site's part from where it is shown; null if nothing here wants that any more.
HandLoop::Owned* HandLoop::joinAsCoHolder(PartId part, sync::Micros sessionNow) {
  Followed* slot = slotOf(part);
  const bool wanted = controls_.asked(part) || (slot != nullptr && slot->asked) ||
                      std::any_of(grasps_.begin(), grasps_.end(), [&](const Grasp& grasp) {
                        return grasp.has(Stage::asked, part) && grasp.wantedBefore;
                      });
  Owned* entry = wanted ? ownedEntry(kNoPart) : nullptr;
  if (!entry) return nullptr;
  *entry = {.part = part, .idleSince = sessionNow};
  if (slot != nullptr) {
    entry->seen = slot->seen;
    slot->part = kNoPart;
  } else {
    entry->seen.restart(state_.worldFromPart(part), sessionNow);
  }
  static_cast<void>(controls_.granted(part));
  command(PartCommand::Kind::own, part, state_.worldFromPart(part));
  for (std::uint8_t hand = 0; hand < haptics::kHands; ++hand)
    if (grasps_[hand].has(Stage::asked, part)) hold(hand);
  return entry;
}

NearParts::Moving HandLoop::coHeldAt(PartId part) const {
  const haptics::OwnedPart* guest = output_.tick.simulated(part);
  return guest != nullptr ? NearParts::Moving{part, guest->worldFromPart, guest->twist}
                          : NearParts::Moving{part, state_.worldFromPart(part), {}};
}

/// What a guest's hands let be is the owner's alone again.
void HandLoop::leaveUntouched(sync::Micros sessionNow) {
  for (Owned& owned : owned_) {
    if (owned.part == kNoPart || !owned.coHeld()) continue;
    if (isHeld(owned.part) || meetsHeld(coHeldAt(owned.part), NearParts::kStillNear))
      owned.idleSince = sessionNow;
    if (sessionNow - owned.idleSince < kCoHolderStays) continue;
    if (!ask({HandIntent::Kind::leave, owned.part, 0, {}})) continue;
    command(PartCommand::Kind::disown, owned.part);
    links_.forget(owned.part, state_);
    const Owned left = std::exchange(owned, {});
    if (Followed* slot = slotFor(left.part, sessionNow)) slot->seen = left.seen;  // from where it is here
  }
}

/// One part a tick: what the tool presses on, or what is to be set.
void HandLoop::askForControls() {
  const auto owned = [this](PartId part) { return ownedEntry(part) != nullptr; };
  const PartId part = controls_.wanted(output_.tick, owned);
  if (part != kNoPart && !ask({HandIntent::Kind::grab, part, 0, {}})) controls_.askLater(part);
  const std::optional<PartId> set = controls_.toSet(owned);
  if (!set || output_.tick.held == *set || output_.tick.second.held == *set || ownedEntry(*set)->releasing)
    return;
  if (const std::optional<Pose> pose = controls_.granted(*set)) {
    command(PartCommand::Kind::disown, *set);
    command(PartCommand::Kind::own, *set, *pose);
  }
}

/// A control that this hand asked for is owned where it is here, without a grasp: the tool rests on it, and
/// must not be moved by a pose that comes from elsewhere.
bool HandLoop::takeControl(const sync::PartRecord& record) {
  if (!controls_.asked(record.part)) return false;
  Owned* entry = ownedEntry(kNoPart);
  if (!entry) return false;
  *entry = {.part = record.part, .epoch = record.epoch};
  if (Followed* slot = slotOf(record.part)) slot->part = kNoPart;
  command(PartCommand::Kind::own, record.part,
          controls_.granted(record.part).value_or(state_.worldFromPart(record.part)));
  for (std::uint8_t hand = 0; hand < haptics::kHands; ++hand)
    if (grasps_[hand].has(Stage::asked, record.part)) hold(hand);  // the button went down on it meanwhile
  return true;
}

/// The part that a hand asked for is simulated here now.
void HandLoop::hold(std::uint8_t hand) {
  Grasp& grasp = grasps_[hand];
  grasp.stage = grasp.wantedBefore ? Stage::holding : Stage::idle;
  if (Owned* mine = ownedEntry(grasp.part)) mine->handled = true;
  if (grasp.wantedBefore) command(PartCommand::Kind::grasp, grasp.part, {}, hand);
}

void HandLoop::beginTaking(const sync::PartRecord& record, sync::Micros sessionNow) {
  // For the hand that asked; what nobody waits for any more is the first hand's, if that is free.
  Grasp& grasp = grasps_[1].has(Stage::asked, record.part) && !grasps_[0].has(Stage::asked, record.part)
                     ? grasps_[1]
                     : grasps_[0];
  if (grasp.stage == Stage::taking || grasp.stage == Stage::holding) {
    // A grant that this hand no longer waits for: own it where it is, at rest, and give it back.
    if (Owned* free = ownedEntry(kNoPart)) {
      *free = {.part = record.part, .epoch = record.epoch};
      if (Followed* slot = slotOf(record.part)) slot->part = kNoPart;
      command(PartCommand::Kind::own, record.part, record.worldFromPart);
    }
    return;
  }
  follow(record, sessionNow,
         near(state_.worldFromPart(record.part), record.worldFromPart, kTakeTolerance) ? 0 : kBlend);
  grasp.taking = record;
  grasp.takingUntil = sessionNow + kBlend;
  grasp.stage = Stage::taking;
  grasp.part = record.part;
}

void HandLoop::finishTaking(std::uint8_t hand, sync::Micros sessionNow) {
  Grasp& grasp = grasps_[hand];
  if (grasp.stage == Stage::asked) {
    const Owned* mine = ownedEntry(grasp.part);  // the other hand has it meanwhile
    if (mine && !mine->releasing) hold(hand);
  }
  if (grasp.stage != Stage::taking) return;
  const sync::PartRecord& taking = grasp.taking;
  const bool there = near(state_.worldFromPart(taking.part), taking.worldFromPart, kTakeTolerance);
  if (!there && sessionNow < grasp.takingUntil) return;
  Owned* entry = ownedEntry(kNoPart);
  if (!entry) return;  // eight parts still settle: wait for one to rest
  *entry = {.part = taking.part, .epoch = taking.epoch};
  if (Followed* slot = slotOf(taking.part)) slot->part = kNoPart;
  command(PartCommand::Kind::own, taking.part, taking.worldFromPart);
  hold(hand);  // unless it was let go while the answer was on its way: then it rests, and is released
}

void HandLoop::loseOwned(Owned& owned, const sync::PartRecord& record, sync::Micros sessionNow) {
  command(PartCommand::Kind::disown, owned.part);
  links_.forget(owned.part, state_);
  for (Grasp& grasp : grasps_)
    if (grasp.has(Stage::holding, owned.part)) grasp.stage = Stage::idle;
  if (!owned.releasing) controls_.denied(record.part);  // taken away, not given back
  owned = {};
  const bool still = near(state_.worldFromPart(record.part), record.worldFromPart, kTakeTolerance);
  follow(record, sessionNow, still ? 0 : kLossBlend);
}

void HandLoop::follow(const sync::PartRecord& record, sync::Micros sessionNow, sync::Micros blend) {
  for (Grasp& grasp : grasps_)
    if (grasp.has(Stage::taking, record.part) && record.owner != timeBase_.self) grasp.stage = Stage::idle;
  if (Followed* slot = slotFor(record.part, sessionNow)) {
    slot->owned = record.owner != kNoSite;
    slot->playOut.restart(record.worldFromPart, sessionNow, blend);
    slot->seen.standAt(record.worldFromPart, sessionNow);
  } else {
    command(PartCommand::Kind::setPose, record.part, record.worldFromPart);
  }
}

void HandLoop::followGrasp(bool wanted, std::uint8_t hand, PartId touched) {
  Grasp& grasp = grasps_[hand];
  const Grasp& other = grasps_[1 - hand];
  const bool pressed = wanted && !grasp.wantedBefore;
  const bool lifted = !wanted && grasp.wantedBefore;
  grasp.wantedBefore = wanted;
  if (pressed && grasp.stage == Stage::idle) {
    const PartId wish = grasp.wish != kNoPart ? grasp.wish : hand == 0 ? settings_.wish : kNoPart;
    const PartId part = wish != kNoPart ? wish : touched;
    if (part >= scene_.scene().parts.size() || !scene_.scene().parts[part].movable) return;
    grasp.part = part;
    Owned* mine = ownedEntry(part);
    if (mine && !mine->releasing) {  // still settling in this hand's care, or in the other hand
      hold(hand);
    } else if (controls_.asked(part) || other.has(Stage::asked, part) || other.has(Stage::taking, part)) {
      grasp.stage = Stage::asked;
    } else if (ask({HandIntent::Kind::grab, part, 0, {}})) {
      grasp.stage = Stage::asked;
    }
  }
  if (lifted && grasp.stage == Stage::holding) {
    command(PartCommand::Kind::letGo, grasp.part, {}, hand);
    grasp.stage = Stage::idle;
  }
}

void HandLoop::playOutFollowed(sync::Micros sessionNow) {
  movedCount_ = 0;
  for (Followed& slot : followed_) {
    if (slot.part == kNoPart) continue;
    sync::PlayOut::Shown shown = slot.playOut.at(sessionNow, timeBase_.playOutDelay);
    if (slot.control != nullptr) keepToStops(*slot.control, shown);
    moved_[movedCount_++] = {slot.part, shown.worldFromPart, shown.still ? Twist{} : shown.twist};
    const Pose drawn = slot.control != nullptr ? shown.worldFromPart : slot.seen.at(sessionNow);
    // What is shown last stays on the screen: it ends where the part is.
    const bool over = !slot.owned && shown.still && sync::PosePrediction::near(drawn, shown.worldFromPart);
    show({slot.part, false, sessionNow - timeBase_.playOutDelay, shown.worldFromPart,
          over ? shown.worldFromPart : drawn});
    if (over) slot.part = kNoPart;
  }
}

/// Between two states, and beyond the last one, playing out knows nothing of the axis and the stops of a control.
void HandLoop::keepToStops(const assets::Control& control, sync::PlayOut::Shown& shown) {
  const double value = assets::controlValue(control, shown.worldFromPart);
  const double possible = assets::admissible(control, value);
  if (possible != value) shown.twist = {};
  shown.worldFromPart = assets::poseAt(control, possible);
}

void HandLoop::releaseRested(sync::Micros sessionNow) {
  for (int i = 0; i < output_.tick.ownedCount; ++i) {
    const haptics::OwnedPart& part = output_.tick.owned[static_cast<std::size_t>(i)];
    Owned* mine = ownedEntry(part.part);
    const bool guest = mine && mine->coHeld() && !mine->releasing;
    show({part.part, true, sessionNow, part.worldFromPart,
          guest ? mine->seen.at(sessionNow) : part.worldFromPart});
    if (!mine || mine->coHeld() || mine->releasing || part.held) continue;
    if (!part.atRest && links_.simulators(part.part) == 1) continue;  // else it is left to who shares it
    mine->releasing = ask({HandIntent::Kind::release, part.part, mine->epoch, part.worldFromPart});
  }
}

void HandLoop::publish(const haptics::DeviceSample& sample, sync::Micros now) {
  output_.time = now;
  output_.device = sample;
  output_.flagsSeen |= output_.tick.flags;
  // It lasts for one tick: nobody would see it.
  constexpr sync::Micros kShown = sync::kSecond;
  if (output_.tick.flags & haptics::kFlagPopThrough) gaveWayUntil_ = now + kShown;
  output_.gaveWay = now < gaveWayUntil_;
  output_.fault = state_.fault().condition;
  output_.grabPending = false;
  for (const Grasp& grasp : grasps_)
    output_.grabPending = output_.grabPending || grasp.stage == Stage::asked || grasp.stage == Stage::taking;
  for (int i = 0; i < output_.tick.ownedCount; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const Owned* mine = ownedEntry(output_.tick.owned[index].part);
    // From its release on it may be another's, though this site has not heard of that.
    output_.ownedEpoch[index] = mine && !mine->releasing ? mine->epoch : 0;
  }
  exchange_.output.write(output_);
  exchange_.view.write(output_);
  // A full ring is a plot that nobody draws.
  static_cast<void>(exchange_.forces.push(static_cast<float>(glm::length(output_.tick.toHand.force))));
  refreshOne();
}

void HandLoop::show(const ShownPose& shown) {
  // A full ring means a window that stands still; refreshOne() heals what it missed.
  shownDropped_ += exchange_.shown.push(shown) ? 0 : 1;
}

void HandLoop::showAsItIs(PartId part, sync::Micros sessionNow) {
  const Pose& pose = state_.worldFromPart(part);
  show({part, false, sessionNow, pose, pose});
}

void HandLoop::refreshOne() {
  if (shownDropped_ == 0) return;
  showAsItIs(refresh_, 0);
  refresh_ = static_cast<PartId>((refresh_ + 1u) % scene_.scene().parts.size());
}

/// False if the network thread takes nothing now.
bool HandLoop::ask(HandIntent intent) {
  intent.lost = lost_;
  return exchange_.intents.push(intent);
}

HandLoop::Followed* HandLoop::slotOf(PartId part) {
  for (Followed& slot : followed_)
    if (slot.part == part) return &slot;
  return nullptr;
}

HandLoop::Followed* HandLoop::slotFor(PartId part, sync::Micros sessionNow) {
  if (Followed* slot = slotOf(part)) return slot;
  Followed* slot = slotOf(kNoPart);
  if (!slot) return nullptr;
  slot->part = part;
  slot->owned = true;
  slot->asked = false;
  slot->control = assets::controlOf(scene_.scene(), part);
  slot->playOut.restart(state_.worldFromPart(part), sessionNow, 0);
  slot->seen.restart(state_.worldFromPart(part), sessionNow);
  return slot;
}

HandLoop::Owned* HandLoop::ownedEntry(PartId part) {
  for (Owned& owned : owned_)
    if (owned.part == part) return &owned;
  return nullptr;
}

void HandLoop::command(PartCommand::Kind kind, PartId part, const Pose& pose, std::uint8_t hand) {
  ASSERT(commandCount_ < commands_.size());  // takeEvents() keeps room
  commands_[(commandHead_ + commandCount_) % commands_.size()] = {kind, part, pose, hand};
  ++commandCount_;
}

}  // namespace tandem::client
