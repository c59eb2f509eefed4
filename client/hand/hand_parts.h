#pragma once

// Which parts this site's ticks simulate, as owner or as co-holder, and which they follow; and what moves a
// part from one to the other. The tick is told by commands.
//
// Haptic thread; allocates in the constructor only.

#include <array>

#include "client/hand/command_queue.h"
#include "client/hand/followed_parts.h"
#include "client/hand/hand_links.h"
#include "haptics/tick.h"
#include "sync/wire/ownership_messages.h"

namespace tandem::client {

/// A part that is simulated here.
struct SimulatedHere {
  PartId part = kNoPart;
  Epoch epoch = 0;  // 0: as a co-holder
  bool releasing = false;
  bool reached = false;  // in this tick held, or near a reached part
  // The rest is of a co-holder's part.
  sync::Micros idleSince = 0;      // since when nothing here touches it
  bool handled = false;            // a hand here has held it
  sync::PosePrediction display{};  // display pose, from the owner's states
  bool coHeld() const { return epoch == 0; }
};

class HandParts {
 public:
  /// What is referred to must outlive this.
  HandParts(const assets::Scene& scene, haptics::TickState& state);

  /// The part's entry if it is simulated here, else null.
  SimulatedHere* find(PartId part);
  /// Whether a hand may hold the part at once: it is simulated here and not on its way back.
  bool isReady(PartId part) {
    const SimulatedHere* mine = find(part);
    return mine != nullptr && !mine->releasing;
  }
  bool hasRoom() { return find(kNoPart) != nullptr; }
  std::array<SimulatedHere, haptics::kMaxOwnedParts>& simulated() { return simulated_; }

  /// Begins to simulate a part from this pose, in the epoch of its grant; false if there is no room.
  bool own(PartId part, Epoch epoch, const Pose& worldFromPart);
  /// Begins to simulate another site's part from where it is played out, at rest; or, where a link carries it
  /// before a hand closes on it, `moving`, from where it is by now as far as its states tell. There must be
  /// room.
  SimulatedHere& coHold(PartId part, sync::Micros sessionNow, bool moving);
  /// Stops simulating a co-held part; it is followed from where it is here.
  void leave(SimulatedHere& mine, sync::Micros sessionNow);
  /// Stops simulating a part that this site has lost; it moves to where the record has it.
  void lose(SimulatedHere& mine, const sync::PartRecord& record, sync::Micros sessionNow);

  /// Follows a part from this record on; what others see of it moves there within `blend`.
  void follow(const sync::PartRecord& record, sync::Micros sessionNow, sync::Micros blend);
  /// A state of another site's part, which held at `time`.
  void onState(const sync::PartState& state, sync::Micros time, sync::Micros sessionNow);

  /// Whether the part is where the record has it, to well below what a hand can feel.
  bool isAt(const sync::PartRecord& record) const;
  const Pose& worldFromPart(PartId part) const { return state_.worldFromPart(part); }

  CommandQueue& commands() { return commands_; }
  FollowedParts& followed() { return followed_; }
  HandLinks& links() { return links_; }

  static constexpr sync::Micros kLossBlend = 300 * sync::kMillisecond;

 private:
  static constexpr double kTolerance = 2e-5;  // m and rad

  haptics::TickState& state_;
  CommandQueue commands_;
  FollowedParts followed_;
  HandLinks links_;
  std::array<SimulatedHere, haptics::kMaxOwnedParts> simulated_;  // a part keeps its place
};

}  // namespace tandem::client
