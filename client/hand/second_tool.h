#pragma once

// The bare tool of a second hand: it touches the scene as the first one's does, in a tick of its own.
// Whatever the hand holds is another matter (haptics/grasp/second_hand.h).
//
// Runs in the haptic thread; allocates only in the constructor.

#include <array>
#include <span>

#include "haptics/scene/contact_scene.h"
#include "haptics/tick.h"

namespace tandem::client {

class SecondTool {
 public:
  /// The scene must outlive this.
  explicit SecondTool(const haptics::ContactScene& scene) : scene_(scene), state_(scene) {}

  /// One tick. `moved` are the parts that others move, `first` is the last tick of the first hand, whose
  /// parts this tool meets where they are; `commands` are those that the first hand's tick gets: parts that
  /// are put somewhere are so here too; `sessionTime` as TickInput's. While the hand `holds` a part the tool
  /// touches nothing, and it begins anew where the device then is. Returns what the tool feels.
  Wrench tick(const haptics::DeviceSample& reading, std::span<const haptics::PartMotion> moved,
              const haptics::TickOutput& first, std::span<const haptics::PartCommand> commands,
              const haptics::TickParameters& parameters, double sessionTime, bool holds);

  /// The part under the tool, as TickOutput::touched.
  PartId touched() const { return touched_; }
  void noteStall() { state_.noteStall(); }
  void resetFault() { state_.resetFault(); }
  const haptics::FaultLatch& fault() const { return state_.fault(); }

  static constexpr std::size_t kMostMoved =
      64 + haptics::kMaxOwnedParts;  // that others and the first hand move

 private:
  // Longer without a reading than this, a tick puts the proxy back onto the device.
  static constexpr int kAwayTicks = 300;

  const haptics::ContactScene& scene_;
  haptics::TickState state_;
  std::array<haptics::PartMotion, kMostMoved> moved_;
  std::array<haptics::PartCommand, haptics::kMaxPartCommands> commands_;
  PartId touched_ = kNoPart;
  bool heldBefore_ = false;
  int away_ = 0;  // ticks that are left without a reading
};

}  // namespace tandem::client
