#pragma once

// Which parts of an assembly overlap, touch, or come nearer to each other than asked, all standing where the
// file has them or at poses that are given. Exact on the triangles that contact uses; shapes of glTF are measured as the triangles that
// stand for them (haptics/scene/README.md).
//
// 1. The answer does not depend on the number of threads.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/base/ids.h"
#include "assets/base/pose.h"

namespace tandem::haptics {
class ContactScene;
}

namespace tandem::client {

enum class ClashKind : std::uint8_t {
  hard,       // deeper in each other than rounding explains
  touch,      // surfaces meet, see haptics::touchTolerance()
  clearance,  // apart, but by less than asked
};

/// What was found between two parts, world frame.
struct Clash {
  PartId a = kNoPart, b = kNoPart;
  ClashKind kind = ClashKind::clearance;
  double depth = 0.0;     // m, of a hard clash; its definition is haptics::overlapOf()'s
  double distance = 0.0;  // m, between the surfaces; 0 unless kind is clearance
  glm::dvec3 onA{0.0, 0.0, 0.0},
      onB{0.0, 0.0, 0.0};  // m, points of both surfaces that far apart: the deepest
                           // point and the nearest of the other's surface; of
                           // sheets, one point where they cross
  double facetSag =
      0.0;  // m: how far the facets there may be off the curved surfaces that they stand for, both
            // parts together; what is shallower may be none
  bool contained = false;  // no surfaces cross: one holds the other, or a shell of it
  bool sheets = false;     // open surfaces: depth is how far facets stand through others
  bool mayCollide = true;  // false: a collision filter or a joint lets them pass through each other
};

struct ClashOptions {
  double clearance = 0.0;  // m, below which parts that do not touch are told
  double tolerance = 0.0;  // m, overlaps no deeper are touches; haptics::touchTolerance() is the least
  int threads = 0;         // 0 = all cores
  std::span<const Pose> worldFromPart;      // one a part; empty: where the file has them
  const std::atomic<bool>* stop = nullptr;  // set by anybody: no further pair is begun
  /// Called now and then from the calling thread: pairs done, and of how many. May be empty.
  std::function<void(std::size_t done, std::size_t pairs)> progress;
};

struct ClashReport {
  /// a < b. Pairs that may collide first; of each: hard ones, deepest first, touches, then clearances, nearest first.
  std::vector<Clash> clashes;
  std::size_t pairs = 0;  // whose boxes come as near as the clearance; all others are further apart
  bool complete = true;   // false: stopped before all pairs were asked
};

/// Asks all pairs of parts that have geometry. Throws nothing, allocates, starts threads.
ClashReport findClashes(const haptics::ContactScene& contact, const ClashOptions& options);

/// The same of one pair at given poses, however far apart they are: `clearance` if nothing touches. None
/// where a part has no geometry.
std::optional<Clash> measurePair(const haptics::ContactScene& contact, PartId a, const Pose& worldFromA,
                                 PartId b, const Pose& worldFromB);

/// What a part (`a` of the answer) is nearest to, all parts standing at these poses (one a part): its nearest
/// neighbour among those that it may collide with; the first one found, with its depth, if it overlaps any.
/// None where it has no geometry or is alone.
std::optional<Clash> nearestPart(const haptics::ContactScene& contact, PartId part,
                                 std::span<const Pose> worldFromPart);

}  // namespace tandem::client
