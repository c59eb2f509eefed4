#pragma once

// How far a mesh is from another one that stands for it.

#include "haptics/geometry/triangle_bvh.h"

namespace tandem::client {

/// A bound, m, on the distance of every point of `from` to the nearest point of `to`: at least `least`, and
/// seldom more than 5 % above the larger of that and the true maximum. The distance to one triangle is a
/// convex function, so over a piece of `from` it is largest at a corner; pieces are cut in two until one
/// triangle of `to` is near all three corners.
double distanceBound(const assets::Mesh& from, const haptics::TriangleBvh& to, double least = 0.0);

/// The largest distance, m, of points of `from` to `to`, looked at in steps of at most `spacing`. It proves
/// nothing of what lies between.
double sampledDistance(const assets::Mesh& from, const haptics::TriangleBvh& to, double spacing);
/// m, over the first edges of all triangles; 0 without triangles.
double meanEdge(const assets::Mesh& mesh);

/// What a level is off: the bound on the exact surface's distance to it, or its own sampled distance to the
/// exact surface if that is larger; `spacing` is the mean edge of the exact mesh.
double levelError(const assets::Mesh& exact, const haptics::TriangleBvh& exactTree, double spacing,
                  const assets::Mesh& level, const haptics::TriangleBvh& levelTree);

}  // namespace tandem::client
