#pragma once

// How exact contact of each part has to be: stated by the scene, or a share of the smallest clearance in which
// the part stands, or what suits the scene's size.
//
// 1. The answer does not depend on the number of threads.

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
    clearance,  // a share of the smallest clearance to a neighbour, as parts stand in the file
  };
  From from = From::scene;
  double tolerance = 0.0;      // m; 0 for a part without geometry
  double clearance = 0.0;      // m, the smallest one found; 0: none could matter
  PartId neighbour = kNoPart;  // to which part that is
};

/// The share of a clearance that a distance may be wrong by.
inline constexpr double kShareOfClearance = 1.0 / 8.0;

/// Tolerances of all parts, one a part. Clearances are the exact distances of the triangles, between parts that
/// may collide of which a hand can hold at least one; what is nearer to each other than touchTolerance(), or than the
/// fields of both can tell, touches, and neither that nor what overlaps is a clearance. Distances are sought up
/// to where they would not make a tolerance smaller. `held`: m, diagonal of the smallest part that a hand can
/// hold. `threads`: 0 = all cores.
std::vector<PartTolerance> partTolerances(const assets::Scene& scene, std::span<const Collider> colliders,
                                          double held, int threads);

/// What suits a part with this diagonal where the smallest part that can be held has one of `held`, m.
double usualTolerance(double held, double diagonal);

/// What a field of a mesh with this diagonal can hold, m: a tolerance within what its floats and its budget
/// allow.
double usableTolerance(double tolerance, double diagonal);

}  // namespace tandem::haptics
