#include "client/hand/bare_tool.h"

namespace tandem::client {

Wrench BareTool::tick(const haptics::DeviceSample& reading, std::span<const haptics::PartMotion> moved,
                      const haptics::TickOutput& first, std::span<const haptics::PartCommand> commands,
                      const Felt& felt, const haptics::TickParameters& parameters, double sessionTime,
                      bool holds) {
  moved_.clear();
  commands_.clear();
  for (const haptics::PartMotion& motion : moved)
    if (!moved_.full()) moved_.push_back(motion);
  for (int i = 0; i < first.ownedCount && !moved_.full(); ++i) {
    const haptics::OwnedPart& owned = first.owned[static_cast<std::size_t>(i)];
    moved_.push_back({owned.part, owned.worldFromPart, owned.twist, true});
  }
  for (const haptics::PartCommand& command : commands)
    if (command.kind == haptics::PartCommand::Kind::setPose && !commands_.full())
      commands_.push_back(command);
  if (away_ > 0) --away_;
  if (holds && !heldBefore_) away_ = kAwayTicks;
  heldBefore_ = holds;
  haptics::TickInput input;
  input.hands[0].device = reading;
  input.sections = felt.sections;
  input.lifted = felt.lifted;
  input.sessionTime = sessionTime;
  input.hands[0].device.valid = reading.valid && !holds && away_ == 0;
  input.moved = {moved_.data(), moved_.size()};
  input.commands = {commands_.data(), commands_.size()};
  // Gain, the emergency key and passivity are the second hand's as a whole.
  haptics::TickParameters ofTool = parameters;
  ofTool.gain = 1.0;
  ofTool.zeroForce = ofTool.passivity = false;
  out_ = haptics::tick(input, *scene_, ofTool, state_);
  touched_ = holds ? kNoPart : out_.touched;
  return out_.hands[0].toHand;
}

}  // namespace tandem::client
