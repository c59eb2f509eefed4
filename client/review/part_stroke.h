#pragma once

// What a part costs a tick and how exactly it is felt, measured by a stylus that strokes it as a hand would.

#include <vector>

#include "haptics/scene/contact_world.h"
#include "haptics/tick.h"

namespace tandem::client {

struct PartStroke {
  std::vector<double> tick_us;  // of each tick of the strokes; empty for a part without geometry
  std::size_t touching = 0;     // ticks that the tool touched the part
  /// m: the most by which the place of the tool was off the exact nearest point of the part's triangles, plus
  /// what the facets of round implicit shapes are under those.
  double error = 0.0;
  double longestStep = 0.0;  // m, of the stylus between two of these ticks
};

/// Puts a point tool above some places of the part, lowers it and strokes along the surface at a part's length
/// a second. Ticks in which it is put somewhere are not counted: no hand jumps. `world` and `state` are of the
/// same scene; the state is used up: it belongs to this function from its first call to its last.
PartStroke strokePart(const haptics::ContactScene& contact, const haptics::ContactWorld& world,
                      haptics::TickState& state, PartId part);

}  // namespace tandem::client
