#pragma once

// Measures the cost of a tick on a part and the exactness of its contact, by a stylus that strokes it.

#include <vector>

#include "haptics/scene/contact_world.h"
#include "haptics/tick.h"

namespace tandem::client {

struct PartStroke {
  std::vector<double> tick_us;  // of each tick of the strokes; empty for a part without geometry
  std::size_t touching = 0;     // ticks that the tool touched the part
  /// m: the largest distance of the tool from the exact nearest point of the part's triangles, plus the sag
  /// of the facets of round implicit shapes.
  double error = 0.0;
  double longestStep = 0.0;  // m, of the stylus between two of these ticks
};

/// Places a point tool above several places of the part, lowers it and strokes along the surface at a part's
/// length a second. Ticks in which the tool is placed are not counted. `world` and `state` are of the same
/// scene; the caller must not use the state for anything else.
PartStroke strokePart(const haptics::ContactScene& contact, const haptics::ContactWorld& world,
                      haptics::TickState& state, PartId part);

}  // namespace tandem::client
