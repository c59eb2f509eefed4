#pragma once

// Assemblies of many finely cut parts, for what has to bear them: loading, memory and drawing.

#include "assets/scene/scene.h"

namespace tandem::generate {

/// `parts` movable parts in a square grid in the plane z = 0, centred on the origin, each of a mesh of its
/// own of at least `triangles` triangles: turned castings under waves with a scan's noise, and gears, by
/// turns. They are some 40 mm across and 50 mm apart. Castings are of two colours. Deterministic.
assets::Scene largeAssembly(int parts, int triangles);

}  // namespace tandem::generate
