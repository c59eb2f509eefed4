#pragma once

// Descent of a sample over the mesh of its own part, to the place near it that is deepest in another part.
//
// Samples are sparse beside the facets of a mesh, so that between two of them a part may be deeper than at
// both. Over the edges of two convex surfaces the depth has one maximum. A descent goes to the place near by
// that is lowest over the plane of contact found last, asks for the plane there, and so on; then it searches
// the last edge for the point where the slope of the distance changes its sign. Over a hollow target it ends
// at a place that no place close by is deeper than; along an edge it also looks beyond where the tangents at
// its ends meet, along a sharp one beyond a hump.
//
// 1. Free of state and of allocation.

#include <cstdint>

#include "haptics/touch/sample_touch.h"

namespace tandem::haptics {

/// Where a descent ended.
struct Seat {
  std::uint32_t edge = assets::kNone;    // of the sampled part; kNone: the sample itself is deepest
  glm::dvec3 point{0.0, 0.0, 0.0};       // m, frame of the target
  double along = 0.0;                    // m that the edge goes on at least on both sides
  double least = 1e300;                  // m over the target: no place seen is lower, below 0 inside
  std::uint32_t triangle = kNoTriangle;  // of the target, near
};

/// When a place is worth going to.
struct DescentBounds {
  double slack = 0.0;  // m by which it must be deeper
  double range = 0.0;  // m over the target up to which a place may touch
};

/// When a sample stands for all places near it.
struct LevelBounds {
  double height = 0.0;     // m, of the sample over the target
  double allowance = 0.0;  // m that such a place may be deeper
  double trusted = 0.0;    // m, error of the field up to which it is believed
};

/// m, how much deeper than at a sample of a smooth surface its part may be between this sample and the next
/// ones. It grows with the angle between the direction to the target (-ownUp, unit, frame of the part) and
/// the normals of the faces that meet at the sample.
double smoothDip(const ContactSamples& all, const ContactSample& sample, const glm::dvec3& ownUp);

/// Whether no place near a sample at an edge is deeper in the target than the sample: then a descent is not
/// worth its time. So it is with a peg in its bore, whose surfaces are as round as each other. `up` is the
/// normal of the sample's plane, frame of the target; `alone` where it has no other one.
bool isLevel(const SampledModels& models, const ContactSample& sample, const LevelBounds& bounds,
             const glm::dvec3& up, bool alone);

/// A point of an edge of the sampled part, in that part's frame.
struct EdgePlace {
  std::uint32_t edge = assets::kNone;
  glm::dvec3 point{0.0, 0.0, 0.0};  // m
  bool operator==(const EdgePlace&) const = default;
};

/// The place near a sample at an edge that is deepest in the target, a mesh. `hint` is a triangle of the
/// target that may be near. `known` is a second place from which to descend, near a sample of a smooth
/// surface: where the part is less deep between the two, a descent from the sample alone would not arrive
/// there. Without an edge it is left out.
Seat deepestNear(const SampledModels& models, const ContactSample& sample, const DescentBounds& bounds,
                 std::uint32_t hint, const EdgePlace& known = {});

}  // namespace tandem::haptics
