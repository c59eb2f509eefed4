#pragma once

// Decides which side of a closed shell is solid.

#include <vector>

#include "assets/mesh/halfedge_topology.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// Says for each shell of `mesh` whether it must be turned inside out.
///
/// A closed shell that lies in no other is the outside of a solid and must have a positive volume. A closed
/// shell within another is read relative to the closed shell next around it, as the file has the two: if they
/// face opposite ways it is a cavity of what surrounds it (or a solid within a cavity), if they face the same
/// way it is a solid of its own within; that relation stays as it is. Open and non-orientable shells are
/// never turned.
std::vector<bool> shellsToInvert(const Mesh& mesh, const std::vector<Shell>& shells);

}  // namespace tandem::assets
