#pragma once

// One hand at one site: joins what the others did (play-out) to what this hand feels (tick), and says what it
// wants (intents). Runs inside the servo thread, or on virtual time; allocates only in the constructor.
//
// The life of a grasp, seen from here:
//   idle -button-> asked -granted-> taking (the replica finishes its play-out) -> holding -button up->
//   settling -rest-> releasing -told by the server-> idle. A denial, a lost link or a revoked part lead back
//   to idle; forces fade.
//
// A part that another site owns is shared with it: asked -tie to the owner-> holding, this site being its guest, whose replica
// is tied to the owner's (hand_links.h). A guest whose hand is off leaves; who is passed the part owns it as it is. An
// owner whose hand is off leaves it to a guest at once; one that loses the part while it holds on asks to be a guest.
//
// A second hand of the same person, on a device of its own, goes the same way; both hold parts of one tick, so that what
// they do to each other stays here. What it touches with its bare tool is felt, but gives way to the first hand only.
//
// Controls are asked for without the button, when the tool presses on one, and are not grasped
// (control_hand.h).

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "assets/base/pose.h"
#include "client/hand/control_hand.h"
#include "client/hand/hand_links.h"
#include "client/hand/near_parts.h"
#include "client/hand/second_tool.h"
#include "client/session/exchange.h"
#include "haptics/scene/contact_scene.h"
#include "haptics/servo/servo_schedule.h"
#include "haptics/tick.h"
#include "sync/replica/play_out.h"
#include "sync/replica/pose_prediction.h"

namespace tandem::client {

class HandLoop {
 public:
  /// The scene and the exchange must outlive this.
  HandLoop(const haptics::ContactScene& scene, Exchange& exchange);

  /// The same person's other hand is on a device too: tick() is given its reading from now on. Allocates; before the
  /// first tick.
  void addSecondHand();

  /// One tick at local time `now`. The wrench is what the device gets. `second`: the reading of the second hand, whose
  /// device gets output().tick.second.toHand; null: there is none.
  Wrench tick(const haptics::DeviceSample& reading, sync::Micros now,
              const haptics::DeviceSample* second = nullptr);

  /// What the last tick() took, as a share of its period: ticks that run short give held parts less effort. Haptic
  /// thread, after tick(), where ticks run in real time.
  void took(double share) { effort_.note(share); }

  /// A part to grasp whatever the stylus of a hand touches; kNoPart: the touched one. Haptic thread, before tick().
  void setWish(PartId part, std::size_t hand = 0) { grasps_[hand].wish = part; }

  /// Sets a control as soon as the server lets this site have it, once for each new count. Haptic thread,
  /// before tick().
  void setControl(const ControlWish& wish, std::size_t hand = 0);

  const HandOutput& output() const { return output_; }
  const Pose& worldFromPart(PartId part) const { return state_.worldFromPart(part); }

  /// Parts that others move at the same time, played out smoothly; more than that jump to their states.
  static constexpr std::size_t kMaxFollowed = 64;
  /// A replica nearer than this to the pose of its grant is taken at once, m and rad: well below what a hand
  /// can tell.
  static constexpr double kTakeTolerance = 2e-5;
  /// A gap between ticks as long as a device's own watchdog: the hand was without force meanwhile.
  static constexpr sync::Micros kStall = 50 * sync::kMillisecond;
  /// Without a reading for longer than a quarter of a second, the tick puts the proxy back onto the device.
  static constexpr int kReseatTicks = 300;
  static constexpr sync::Micros kBlend = 100 * sync::kMillisecond;
  static constexpr sync::Micros kLossBlend = 300 * sync::kMillisecond;
  /// A guest stays for so long after its hand is off.
  static constexpr sync::Micros kCoHolderStays = 500 * sync::kMillisecond;

 private:
  struct Followed {
    PartId part = kNoPart;
    bool owned = false;  // by somebody: keep the slot
    const assets::Control* control = nullptr;
    bool asked = false;           // to be simulated here, for it comes near to what is held
    sync::PlayOut playOut;        // for the hand
    sync::PosePrediction seen{};  // for the eyes
  };
  /// A part that is simulated here.
  struct Owned {
    PartId part = kNoPart;
    Epoch epoch = 0;  // 0: as a guest of its owner
    bool releasing = false;
    sync::Micros idleSince = 0;   // a guest: since when nothing here touches it
    bool handled = false;         // a guest: a hand here has held it
    sync::PosePrediction seen{};  // a guest: the owner's, for the eyes
    bool coHeld() const { return epoch == 0; }
  };
  enum class Stage : std::uint8_t { idle, asked, taking, holding };
  /// A hand on its way to a part.
  struct Grasp {
    Stage stage = Stage::idle;
    PartId part = kNoPart;    // asked, taking or holding
    sync::PartRecord taking;  // while taking
    sync::Micros takingUntil = 0;
    bool wantedBefore = false;
    PartId wish = kNoPart;
    bool has(Stage of, PartId which) const { return stage == of && part == which; }
  };

  bool noteStall(sync::Micros now);
  haptics::DeviceSample afterStall(haptics::DeviceSample sample, bool stalled, std::uint8_t hand);
  void readSettings();
  void takeEvents(sync::Micros sessionNow);
  void takeState(const sync::PartState& state, sync::Micros time, sync::Micros sessionNow);
  void takeOwnership(const sync::PartRecord& record, sync::Micros sessionNow);
  void beginTaking(const sync::PartRecord& record, sync::Micros sessionNow);
  void loseOwned(Owned& owned, const sync::PartRecord& record, sync::Micros sessionNow);
  void stopAsking(PartId part);
  void takeDenial(const sync::PartRecord& record, sync::Micros sessionNow);
  void takeLink(const NetworkEvent& order, sync::Micros sessionNow);
  Owned* joinAsCoHolder(PartId part, sync::Micros sessionNow);
  void leaveUntouched(sync::Micros sessionNow);
  bool isHeld(PartId part) const;
  bool meetsHeld(const NearParts::Moving& other, double near) const;
  NearParts::Moving coHeldAt(PartId part) const;
  void askForNear();
  void follow(const sync::PartRecord& record, sync::Micros sessionNow, sync::Micros blend);
  void followGrasp(bool wanted, std::uint8_t hand, PartId touched);
  void finishTaking(std::uint8_t hand, sync::Micros sessionNow);
  void hold(std::uint8_t hand);
  Wrench feelSecondTool(std::size_t batch, sync::Micros sessionNow);
  void noteSecond();
  void playOutFollowed(sync::Micros sessionNow);
  static void keepToStops(const assets::Control& control, sync::PlayOut::Shown& shown);
  void askForControls();
  bool takeControl(const sync::PartRecord& record);
  void releaseRested(sync::Micros sessionNow);
  void show(const ShownPose& shown);
  void showAsItIs(PartId part, sync::Micros sessionNow);
  void refreshOne();
  void publish(const haptics::DeviceSample& sample, sync::Micros now);

  bool ask(HandIntent intent);
  Followed* slotOf(PartId part);
  Followed* slotFor(PartId part, sync::Micros sessionNow);
  Owned* ownedEntry(PartId part);
  void command(haptics::PartCommand::Kind kind, PartId part, const Pose& pose = {}, std::uint8_t hand = 0);

  const haptics::ContactScene& scene_;
  Exchange& exchange_;
  haptics::TickState state_;
  HandOutput output_;
  HandSettingsInput settings_;
  TimeBase timeBase_;
  haptics::EffortGuard effort_;
  std::uint32_t faultResetsSeen_ = 0, reseatsSeen_ = 0;
  std::uint32_t wishesSeen_ = 0;                                     // of controls
  std::array<std::uint32_t, haptics::kHands> scriptedWishesSeen_{};  // the same
  int reseatTicks_ = 0;  // ticks without a reading that are left until the tip is back on the device

  std::array<Followed, kMaxFollowed> followed_;
  std::array<Owned, haptics::kMaxOwnedParts> owned_;
  HandLinks links_;
  NearParts near_;
  std::array<haptics::PartMotion, kMaxFollowed> moved_;
  std::size_t movedCount_ = 0;
  /// Commands that wait for a tick with room; the ring is as large as a session's parts, so a reset of all
  /// fits.
  std::vector<haptics::PartCommand> commands_;
  std::size_t commandHead_ = 0, commandCount_ = 0;
  std::array<haptics::PartCommand, haptics::kMaxPartCommands> commandBatch_;

  ControlHand controls_;
  std::array<Grasp, haptics::kHands> grasps_;
  std::unique_ptr<SecondTool> secondTool_;  // null: there is no second hand
  haptics::SecondHand second_;
  static_assert(SecondTool::kMostMoved >= kMaxFollowed + haptics::kMaxOwnedParts);
  sync::Micros gaveWayUntil_ = 0;  // local time: for how long the view tells of a surface that gave way
  sync::Micros lastTick_ = 0;
  std::uint32_t lost_ = 0;  // connections
  // The loop stood still: the coupling of a hand begins again at its next good reading.
  std::array<bool, haptics::kHands> graspAnew_{};

  std::uint64_t shownDropped_ = 0;  // once a pose was dropped, one part a tick is shown again
  PartId refresh_ = 0;
};

}  // namespace tandem::client
