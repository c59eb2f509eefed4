#pragma once

// The way of a part out of its assembly in the picture: a line, the part faintly along it, and what is in the
// way of a part that does not come out.

#include <vector>

#include "client/marks/part_display.h"
#include "client/picture/glyphs.h"

namespace tandem::client {

/// Poses along the way, as far apart as each other, with its end and without its beginning; at most `most`.
std::vector<Pose> posesAlong(const std::vector<Pose>& path, std::size_t most);
/// How the part is drawn at these.
PartLook wayLook(bool free);
/// Adds the way of the part's middle.
void addWayOut(const ViewModel& model, GlyphBatch& batch);
/// Colours what blocks the part, and makes it transparent.
void markBlockers(const WayOutView& wayOut, std::vector<PartLook>& looks);

}  // namespace tandem::client
