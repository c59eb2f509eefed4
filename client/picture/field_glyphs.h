#pragma once

#include "client/picture/glyphs.h"
#include "client/session/view_model.h"

namespace tandem::client {

/// Adds a mark for each force field of the scene to the batch: an arrow along a constant force or waveform
/// (two heads: to and fro), the line of a path, a ball for what draws to a centre, a ring for what damps or
/// stands as a line or plane; and the outline of its region. Marks have sizes in pixels; regions and paths
/// are drawn to scale.
void addFields(const ViewModel& model, GlyphBatch& batch);

}  // namespace tandem::client
