#pragma once

// Whether the parts of a decoded update are those that were sent.

#include <algorithm>

#include "sync/wire/wire.h"

namespace tandem::sync::testing {

/// Whether both updates have the same parts, at the poses and twists of `sent` as quantised by the wire.
inline bool havePartsOf(const StateUpdate& sent, const StateUpdate& got, const WireFrame& frame) {
  if (sent.parts.size() != got.parts.size()) return false;
  return std::all_of(sent.parts.begin(), sent.parts.end(), [&](const PartState& state) {
    const PartState expected = quantised(state, frame);
    const auto at = std::find_if(got.parts.begin(), got.parts.end(),
                                 [&](const PartState& other) { return other.part == state.part; });
    return at != got.parts.end() && at->epoch == expected.epoch && at->sequence == expected.sequence &&
           at->worldFromPart.position == expected.worldFromPart.position &&
           at->worldFromPart.orientation == expected.worldFromPart.orientation &&
           at->twist.linear == expected.twist.linear && at->twist.angular == expected.twist.angular;
  });
}

}  // namespace tandem::sync::testing
