#pragma once

#include "haptics/tick.h"

namespace tandem::client::report {

/// Parameters without damping and limits: the force is the stiffness (N/m) times the depth, and can be
/// compared. The tool's radius is in m.
inline haptics::TickParameters bareSpring(double stiffness, double toolRadius = 0.0) {
  haptics::TickParameters p;
  p.toolRadius = toolRadius;
  p.stiffness = stiffness;
  p.damping = 0.0;
  p.forceLimit = 1e9;
  p.slewLimit = 1e12;
  return p;
}

}  // namespace tandem::client::report
