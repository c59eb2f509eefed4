#include "client/hand/second_tool.h"

namespace tandem::client {

Wrench SecondTool::tick(const haptics::DeviceSample& reading, std::span<const haptics::PartMotion> moved,
                        const haptics::TickOutput& first, std::span<const haptics::PartCommand> commands,
                        const haptics::TickParameters& parameters, double sessionTime, bool holds) {
  std::size_t movedCount = 0, commandCount = 0;
  for (const haptics::PartMotion& motion : moved)
    if (movedCount < moved_.size()) moved_[movedCount++] = motion;
  for (int i = 0; i < first.ownedCount && movedCount < moved_.size(); ++i) {
    const haptics::OwnedPart& owned = first.owned[static_cast<std::size_t>(i)];
    moved_[movedCount++] = {owned.part, owned.worldFromPart, owned.twist};
  }
  for (const haptics::PartCommand& command : commands)
    if (command.kind == haptics::PartCommand::Kind::setPose && commandCount < commands_.size())
      commands_[commandCount++] = command;
  if (away_ > 0) --away_;
  if (holds && !heldBefore_) away_ = kAwayTicks;
  heldBefore_ = holds;
  haptics::TickInput input;
  input.device = reading;
  input.sessionTime = sessionTime;
  input.device.valid = reading.valid && !holds && away_ == 0;
  input.moved = {moved_.data(), movedCount};
  input.commands = {commands_.data(), commandCount};
  // Gain, the emergency key and passivity are the second hand's as a whole.
  haptics::TickParameters ofTool = parameters;
  ofTool.gain = 1.0;
  ofTool.zeroForce = ofTool.passivity = false;
  const haptics::TickOutput out = haptics::tick(input, scene_, ofTool, state_);
  touched_ = holds ? kNoPart : out.touched;
  return out.toHand;
}

}  // namespace tandem::client
