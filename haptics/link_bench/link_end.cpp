#include "haptics/link_bench/link_end.h"

namespace tandem::bench {

using haptics::SixAxes;

void PlainSpringEnd::receive(const haptics::LinkPacket& packet) {
  if (heard_ && packet.time <= peer_.time) return;
  peer_ = packet;
  heard_ = true;
}

/// The spring acts at the end of the step (backward Euler), like the coupling of a hand to a part, so its
/// only flaw is the delay.
haptics::LinkPull PlainSpringEnd::pull(double, const Pose& worldFromCentre, const Twist&) {
  if (!heard_) return {{}, kDrag, kDrag * lever_ * lever_};
  const SixAxes force =
      gains_.stiffness * haptics::displacementBetween(worldFromCentre, peer_.worldFromDrawn, lever_) +
      gains_.damping * haptics::axesOf(peer_.twist, lever_);
  const double damping = gains_.damping + gains_.stiffness * period_ + kDrag;
  return {haptics::wrenchOf(force, lever_), damping, damping * lever_ * lever_};
}

void PlainSpringEnd::account(const Pose& worldFromCentre, const Twist& twist) {
  own_.worldFromDrawn = worldFromCentre;
  own_.twist = twist;
}

haptics::LinkPacket PlainSpringEnd::packet(double now) {
  own_.time = now;
  ++own_.sequence;
  return own_;
}

}  // namespace tandem::bench
