#pragma once

namespace tandem::haptics {

/// What a tick may spend on contact between parts. Less is faster, and errs to the safe side only while `exact` holds:
/// parts then go less far than they could, and never into each other.
struct ContactEffort {
  int steps = 4;    // at most, 1 to 4: what is left of a fast motion is made up in the next ticks
  int looks = 600;  // at most, of all steps: rows looked at or made active
  bool exact =
      true;  // look at the triangles where a field cannot be trusted; else its reading is taken as it is
};

}  // namespace tandem::haptics
