#pragma once

// One person's hands at one site: joins what others do (play-out) to what the hands feel (tick), and tells
// the network thread what they want (intents). Runs inside the servo thread, or on virtual time; allocates
// only in the constructor.
//
// 1. A grasp has the stages of grasp.h. A part that nobody holds any more comes to rest and is released; a
//    part that is revoked, or lost with the connection, is followed instead, while the force of its coupling
//    fades.
// 2. A part of another site is co-held: this site simulates a replica that a coordination link couples to the
//    owner's. A co-holder whose hand is off leaves; one that is given the part owns its replica as it is. An
//    owner whose hand is off leaves the part to a co-holder at once; one that loses the part while it holds
//    on asks to be a co-holder.
// 3. A second hand of the same person, on a device of its own, grasps in the same way. Both hands hold parts
//    of one tick, so forces between them stay here. What its bare tool touches is felt, but gives way to the
//    first hand only.
// 4. Controls are asked for without the button, when the tool presses on one, and are not grasped
//    (control_hand.h).
// 5. While parts are shown elsewhere than they are (HandSettingsInput::lifted) the hands let go, feel nothing
//    and take nothing; what they have let go of, and what others move, goes on as ever.

#include <array>
#include <cstdint>
#include <memory>

#include "assets/base/pose.h"
#include "client/hand/bare_tool.h"
#include "client/hand/control_hand.h"
#include "client/hand/display_poses.h"
#include "client/hand/grasps.h"
#include "client/hand/hand_intents.h"
#include "client/hand/hand_parts.h"
#include "client/hand/near_parts.h"
#include "client/hand/stall_guard.h"
#include "client/session/exchange.h"
#include "haptics/scene/contact_scene.h"
#include "haptics/servo/servo_schedule.h"
#include "haptics/tick.h"

namespace tandem::client {

class HandLoop {
 public:
  /// The scene and the exchange must outlive this.
  HandLoop(const haptics::ContactScene& scene, Exchange& exchange);
  HandLoop(const HandLoop&) = delete;
  HandLoop& operator=(const HandLoop&) = delete;

  /// The same person's other hand is on a device too: tick() is given its reading from now on. Allocates;
  /// before the first tick.
  void addSecondHand();

  /// Lets these threads run parts of heavy ticks (TickState::share()). To be called before the first tick;
  /// allocates.
  void share(haptics::TickHelpers* helpers) { state_.share(helpers); }

  /// One tick at local time `now`. The wrench is what the device gets. `second`: the reading of the second
  /// hand, whose device gets output().tick.hands[1].toHand; null: there is none.
  Wrench tick(const haptics::DeviceSample& reading, sync::Micros now,
              const haptics::DeviceSample* second = nullptr);

  /// Goes on with a scene that differs in its models alone (haptics::ModelRefiner). It must outlive this, or
  /// the next call. Haptic thread, between ticks; it costs nothing.
  void refine(const haptics::ContactScene& next) {
    scene_ = &next;
    state_.refine(next);
    if (bareTool_) bareTool_->refine(next);
  }

  /// What the last tick() took, as a share of its period: ticks that run short give held parts less effort.
  /// Haptic thread, after tick(), where ticks run in real time.
  void took(double share) { effort_.note(share); }

  /// A part to grasp whatever the stylus of a hand touches; kNoPart: the touched one. Haptic thread, before
  /// tick().
  void setWish(PartId part, std::size_t hand = 0) { wishes_[hand] = part; }

  /// Sets a control as soon as the server lets this site have it, once for each new count. Haptic thread,
  /// before tick().
  void setControl(const ControlWish& wish, std::size_t hand = 0);

  const HandOutput& output() const { return output_; }
  const Pose& worldFromPart(PartId part) const { return state_.worldFromPart(part); }

  static constexpr sync::Micros kStall = StallGuard::kStall;
  /// A co-holder stays for so long after its hand is off.
  static constexpr sync::Micros kCoHolderStays = 500 * sync::kMillisecond;

 private:
  void readSettings();
  std::span<const haptics::Section> sections() const {
    return {settings_.sections.data(), settings_.sectionCount};
  }
  haptics::DeviceSample afterStall(const haptics::DeviceSample& reading, std::size_t hand);
  void noteStall(sync::Micros now);

  void handleEvents(sync::Micros sessionNow);
  void handle(const NetworkEvent& event, sync::Micros sessionNow);
  void onOwnership(const sync::PartRecord& record, sync::Micros sessionNow);
  void onDenial(const sync::PartRecord& record, sync::Micros sessionNow);
  void onLink(const NetworkEvent& order, sync::Micros sessionNow);
  void onConnectionLost();
  void lose(SimulatedHere& mine, const sync::PartRecord& record, sync::Micros sessionNow);
  void noteOwner(const sync::PartRecord& record);

  SimulatedHere* joinAsCoHolder(PartId part, bool takes, sync::Micros sessionNow);
  void noteReached();
  bool meetsReached(const NearParts::Moving& other, double near);
  NearParts::Moving simulatedAt(PartId part) const;
  void askForNear();
  void askForControls();
  bool ownControl(const sync::PartRecord& record);
  void leaveUntouched(sync::Micros sessionNow);
  void releaseRested(sync::Micros sessionNow);

  void setButtons(const haptics::DeviceSample& sample, bool both);
  Wrench feelBareTool(std::span<const haptics::PartCommand> commands, sync::Micros sessionNow);
  void noteSecondHand();
  void publish(const haptics::DeviceSample& sample, sync::Micros now);

  const haptics::ContactScene* scene_;
  Exchange& exchange_;
  haptics::TickState state_;
  HandOutput output_;
  HandSettingsInput settings_;
  TimeBase timeBase_;
  haptics::EffortGuard effort_;
  std::uint32_t faultResetsSeen_ = 0, reseatsSeen_ = 0;
  std::uint32_t wishesSeen_ = 0;                                     // of controls
  std::array<std::uint32_t, haptics::kHands> scriptedWishesSeen_{};  // the same

  HandIntents intents_;
  HandParts parts_;
  ControlHand controls_;
  Grasps grasps_;
  NearParts near_;
  StallGuard stalls_;
  DisplayPoses display_;
  std::array<PartId, haptics::kHands> wishes_;        // by hand; kNoPart: none
  std::array<bool, haptics::kHands> waitsForLift_{};  // by hand: its button does not count until it is up
  std::array<haptics::HandInput, haptics::kHands> hands_;  // of this tick
  std::unique_ptr<BareTool> bareTool_;                     // of the second hand; null: there is none
  static_assert(BareTool::kMaxMoved >= FollowedParts::kMax + haptics::kMaxOwnedParts);
  sync::Micros poppedThroughUntil_ = 0;  // local time: for how long the view tells of a surface that gave way
};

}  // namespace tandem::client
