#pragma once

// The bare tool of a person's second hand: it touches the scene as the first hand's does, in a tick of its
// own. The parts that the hand holds belong to the tick of both hands (haptics/grasp/hand.h).
//
// Runs in the haptic thread; allocates only in the constructor.

#include <span>

#include "haptics/base/fixed_vector.h"
#include "haptics/scene/contact_scene.h"
#include "haptics/tick.h"

namespace tandem::client {

class BareTool {
 public:
  /// The scene must outlive this.
  explicit BareTool(const haptics::ContactScene& scene) : scene_(&scene), state_(scene) {}

  /// As HandLoop::refine().
  void refine(const haptics::ContactScene& next) {
    scene_ = &next;
    state_.refine(next);
  }

  /// What of the scene the tool feels, as TickInput has it.
  struct Felt {
    std::span<const haptics::Section> sections;
    bool lifted = false;
  };
  /// One tick; returns what the tool feels. `moved` are the parts that others move; `first` is the last
  /// tick of both hands, whose parts the tool meets where they are; of `commands`, those of that tick,
  /// setPose holds here too; `sessionTime`, s, as TickInput's. While the hand `holds` a part the tool
  /// touches nothing; then it begins anew where the device is.
  Wrench tick(const haptics::DeviceSample& reading, std::span<const haptics::PartMotion> moved,
              const haptics::TickOutput& first, std::span<const haptics::PartCommand> commands,
              const Felt& felt, const haptics::TickParameters& parameters, double sessionTime, bool holds);

  /// The part under the tool, as TickOutput::touched.
  PartId touched() const { return touched_; }
  const Pose& worldFromProxy() const { return out_.worldFromProxy; }
  /// Its contacts of the last tick.
  std::span<const haptics::Contact> contacts() const {
    return {out_.contacts.data(), static_cast<std::size_t>(out_.contactCount)};
  }
  void noteStall() { state_.noteStall(); }
  void resetFault() { state_.resetFault(); }
  const haptics::FaultLatch& fault() const { return state_.fault(); }

  // Parts that others and the first hand move.
  static constexpr std::size_t kMaxMoved = 64 + haptics::kMaxOwnedParts;

 private:
  // Longer without a reading than this, a tick puts the proxy back onto the device.
  static constexpr int kAwayTicks = 300;

  const haptics::ContactScene* scene_;
  haptics::TickState state_;
  haptics::FixedVector<haptics::PartMotion, kMaxMoved> moved_;                      // of this tick
  haptics::FixedVector<haptics::PartCommand, haptics::kMaxPartCommands> commands_;  // of this tick
  haptics::TickOutput out_;                                                         // of the last tick
  PartId touched_ = kNoPart;
  bool heldBefore_ = false;
  int away_ = 0;  // ticks that are left without a reading
};

}  // namespace tandem::client
