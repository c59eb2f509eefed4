#pragma once

// Tolerance of contact for each part: stated by the scene, or a fraction of the smallest clearance of the
// part, or derived from the scene's size.
//
// 1. The result does not depend on the number of threads.

#include <cstdint>
#include <span>
#include <vector>

#include "assets/base/ids.h"
#include "assets/scene/scene.h"

namespace tandem::haptics {

struct Collider;

struct PartTolerance {
  enum class From : std::uint8_t {
    scene,      // 2^-14 of the diagonal of the smallest part that a hand can hold
    given,      // the file states it
    clearance,  // a fraction of the smallest clearance to a neighbour in the file's poses
  };
  From from = From::scene;
  double tolerance = 0.0;      // m; 0 for a part without geometry
  double clearance = 0.0;      // m, the smallest one found; 0: none matters
  PartId neighbour = kNoPart;  // the part at that clearance
};

/// The distance error that a clearance allows, as a fraction of it.
inline constexpr double kShareOfClearance = 1.0 / 8.0;

/// Tolerances of all parts. Clearances are exact distances of the triangles, between parts that may collide
/// and of which a hand can hold at least one. Parts nearer than touchTolerance(), or than the fields of both
/// can resolve, touch; neither touching nor overlapping parts have a clearance. Distances are searched only
/// as far as they would tighten a tolerance. `smallestHeld`: m, diagonal of the smallest part that a hand can
/// hold. `threads`: 0 = all cores.
std::vector<PartTolerance> partTolerances(const assets::Scene& scene, std::span<const Collider> colliders,
                                          double smallestHeld, int threads);

/// The same without a search for clearances: at once, and too large where a fit is tight.
std::vector<PartTolerance> tolerancesWithoutClearance(const assets::Scene& scene,
                                                      std::span<const Collider> colliders,
                                                      double smallestHeld);

/// Tolerance of a part with this diagonal where the smallest part that can be held has the diagonal
/// `smallestHeld`, m.
double usualTolerance(double smallestHeld, double diagonal);

/// Limits a tolerance, m, to what the floats and the budget of a field of a mesh with this diagonal allow.
double usableTolerance(double tolerance, double diagonal);

}  // namespace tandem::haptics
