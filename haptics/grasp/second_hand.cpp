#include "haptics/grasp/second_hand.h"

#include <algorithm>

#include <glm/gtc/quaternion.hpp>

namespace tandem::haptics {

void SecondHandPort::note(const SecondHand& hand, const TickParameters& ofFirst, HeldParts& parts,
                          FaultLatch& fault) {
  parameters_ = hand.parameters != nullptr ? *hand.parameters : ofFirst;
  TICK_ASSERT(fault, parameters_.dt == ofFirst.dt);
  flags_ = 0;
  lastTool_ = tool_;
  tool_ = hand.tool;
  move_ = turn_ = glm::dvec3(0.0);
  const SampleGuard::Verdict verdict = guard_.judge(hand.device, parameters_, invalidTime_, flags_);
  valid_ = verdict != SampleGuard::Verdict::refused;
  if (!valid_) {
    flags_ |= kFlagInvalidSample;
    invalidTime_ += parameters_.dt;
    return;
  }
  const Pose &now = hand.device.worldFromDevice, &last = device_.worldFromDevice;
  if (started_ && fade_.active()) {
    move_ = now.position - last.position;
    turn_ = rotationVector(now.orientation * glm::conjugate(last.orientation));
  }
  device_ = felt_ = hand.device;
  if (reading_.note(now.position, parameters_.dt)) felt_.twist.linear = glm::dvec3(0.0);
  const PartId held = parts.held(1);
  if (verdict == SampleGuard::Verdict::elsewhere && held != kNoPart)
    parts.grasp(held, device_.worldFromDevice, parameters_, 1);
  started_ = true;
  invalidTime_ = 0.0;
}

bool SecondHandPort::grasp(PartId part, HeldParts& parts) {
  if (!started_ || !parts.owns(part)) return false;
  if (parts.held(1) == part) return true;
  letGo(parts);
  if (!parts.grasp(part, device_.worldFromDevice, parameters_, 1)) return false;
  fade_.start(lastTool_, {parameters_.stiffness, 0.0}, parameters_.fadeTime);
  return true;
}

void SecondHandPort::letGo(HeldParts& parts) {
  if (parts.held(1) == kNoPart) return;
  const double springs = parts.letGo(parameters_, 1) ? 2.0 : 1.0;
  fade_.start(coupling_, {springs * parameters_.graspStiffness, springs * parameters_.graspRotStiffness},
              parameters_.fadeTime);
  coupling_ = Wrench{};
}

HandPull SecondHandPort::pull() const { return {valid_ ? &felt_ : nullptr, HandPull::gainsOf(parameters_)}; }

SecondHandOutput SecondHandPort::send(const Wrench& coupling, const HeldParts& parts, FaultLatch& fault) {
  SecondHandOutput out;
  coupling_ = valid_ ? coupling : Wrench{};
  if (fade_.active()) fade_.advance(move_, turn_, parameters_.dt);
  const Wrench fading = fade_.now();
  Wrench wanted{coupling_.force + fading.force, coupling_.torque + fading.torque};
  if (valid_ && parts.held(1) == kNoPart) wanted = {wanted.force + tool_.force, wanted.torque + tool_.torque};
  out.toHand = limitOutput(wanted, valid_ ? &device_ : nullptr, {}, parameters_, fault, limits_, flags_);
  const SimulatedPart* const held = parts.heldPart(1);
  out.held = held != nullptr ? held->part : kNoPart;
  out.worldFromGrip =
      held != nullptr ? held->body.worldFromBody * held->grips[1].bodyFromGrip : device_.worldFromDevice;
  out.flags = flags_;
  return out;
}

}  // namespace tandem::haptics
