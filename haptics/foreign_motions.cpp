#include "haptics/foreign_motions.h"

#include <algorithm>

namespace tandem::haptics {
namespace {

constexpr double kJumped = 1.0;  // m: how far is not known

}  // namespace

ForeignMotions::ForeignMotions(std::span<const PartMotion> moved)
    : moved_(moved),
      any_(std::any_of(moved.begin(), moved.end(), [](const PartMotion& motion) { return motion.suspect; })) {
}

bool ForeignMotions::suspects(PartId part) const {
  return any_ && std::any_of(moved_.begin(), moved_.end(), [part](const PartMotion& motion) {
           return motion.part == part && motion.suspect;
         });
}

void ForeignMotions::noteTool(PartId part, double displacement) {
  if (displacement >= 0.0 && suspects(part)) displacement_[0] = std::max(displacement_[0], displacement);
}

void ForeignMotions::notePut(const PartCommand& command) {
  if (command.suspect) displacement_[0] = kJumped;
}

void ForeignMotions::noteTouches(const PartContact* contact) {
  if (contact == nullptr || !any_) return;
  for (const PartTouch& touch : contact->touches())
    if (suspects(touch.part) || suspects(touch.of)) held_ = true;
  if (held_) displacement_.fill(kJumped);
}

ForeignGuard::Tick ForeignMotions::tickOf(int hand, const TickOutput& out, double stiffness) const {
  ForeignGuard::Tick tick;
  tick.foreign = displacement_[static_cast<std::size_t>(hand)];
  for (int i = 0; any_ && i < out.contactCount; ++i)
    tick.touches = tick.touches || suspects(out.contacts[static_cast<std::size_t>(i)].part);
  tick.held = held_;
  tick.stiffness = stiffness;
  return tick;
}

}  // namespace tandem::haptics
