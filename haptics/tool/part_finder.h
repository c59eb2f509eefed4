#pragma once

// The part under a tool that touches nothing: the nearest one whose surface is within its own reach. It
// remembers what the last search found, because most ticks of a tool in the air ask about almost the same
// place.
//
// 1. The answer is that of a search without memory.
// 2. Nothing here allocates. A tick takes at most kMaxTouchQueries queries of nearest points.

#include <cstdint>

#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

// A part may be taken when its surface is within this share of its own bounding diagonal: scale-free.
inline constexpr double kTouchShare = 0.02;
inline constexpr int kMaxTouchQueries = 32;

class PartFinder {
 public:
  /// The touchable part whose surface is nearest to p among those within their own reach, which is max(2
  /// radius, kTouchShare of its own diagonal) from a ball around p; kNoPart without one. `farthest`: the
  /// largest reach of all parts from p, m. Keeps the free space that it finds in the world.
  PartId find(ContactWorld& world, const glm::dvec3& p, double radius, double farthest);

 private:
  bool isStillNearest(const ContactWorld& world, const glm::dvec3& p, double radius) const;
  PartId search(ContactWorld& world, const glm::dvec3& p, double radius, double farthest);
  PartId note(PartId part, std::uint32_t triangle);
  /// Whether nothing has changed since the last search that could bring a surface nearer.
  bool isUndisturbed(const ContactWorld& world) const { return changes_ == world.freeBall().changes(); }

  // The part that the last successful search found, and its nearest triangle.
  PartId part_ = kNoPart;
  std::uint32_t triangle_ = kNoTriangle;
  // A search without result: no part comes within its reach while the tool of that radius stays within
  // `room_` of `place_` and nothing else moves, m.
  glm::dvec3 place_{0.0, 0.0, 0.0};
  double room_ = 0.0, radius_ = 0.0;
  std::uint64_t changes_ = 0;  // of the world's free ball, after the last search
  int queries_ = 0;            // of the last search
};

}  // namespace tandem::haptics
