#pragma once

// Finds the parts of an assembly that overlap, touch, or come nearer to each other than a clearance, at the
// file's poses or at given ones. Exact on the triangles that contact uses; shapes of glTF are measured as
// the triangles that represent them (haptics/scene/README.md).
//
// 1. The answer does not depend on the number of threads, nor on how a mesh is split into vertices and
//    pose.

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
#include "client/review/part_closings.h"

namespace tandem::client {

enum class ClashKind : std::uint8_t {
  hard,       // deeper in each other than rounding explains
  touch,      // surfaces meet, see haptics::touchTolerance()
  clearance,  // apart, but nearer than the clearance
};

/// What was found between two parts, world frame.
struct Clash {
  PartId a = kNoPart, b = kNoPart;
  ClashKind kind = ClashKind::clearance;
  double depth =
      0.0;  // m, of a hard clash; its definition is haptics::overlapOf()'s. Of an open one, at least
  double distance = 0.0;  // m, between the surfaces; 0 unless kind is clearance
  /// m, the witness points, one on each surface: the deepest point and the nearest one of the other surface;
  /// of sheets, one point where they cross.
  glm::dvec3 onA{0.0, 0.0, 0.0}, onB{0.0, 0.0, 0.0};
  /// m: where a hard clash is deepest, on the surface of one part and in or on the other (where surfaces
  /// coincide: in both); one of onA and onB, but there.
  glm::dvec3 deepest{0.0, 0.0, 0.0};
  /// m: how far the facets at the witness points may be off the curved surfaces that they represent, both
  /// parts together. A shallower overlap may be an artefact of the facets.
  double facetSag = 0.0;
  bool contained = false;  // no surfaces cross: one part holds the other, or a shell of it
  bool open = false;       // the depth cannot be known because a shell is open
  bool sheets = false;     // open surfaces: depth is how far a facet reaches through another; open too
  bool mayCollide = true;  // false: a collision filter or a joint lets them pass through each other
};

struct ClashOptions {
  double clearance = 0.0;  // m, below which parts that do not touch are reported
  double tolerance = 0.0;  // m, overlaps no deeper count as touches; haptics::touchTolerance() is the minimum
  int threads = 0;         // 0 = all cores
  std::span<const Pose> worldFromPart;      // one a part; empty: the file's poses
  const std::atomic<bool>* stop = nullptr;  // once true, no further pair is begun
  /// Called now and then in the calling thread: pairs done, and the number of all. May be empty.
  std::function<void(std::size_t done, std::size_t pairs)> progress;
};

struct ClashReport {
  /// a < b. Pairs that may collide first; of each: hard ones of known depth, deepest first, those of unknown
  /// depth, touches, then clearances, nearest first.
  std::vector<Clash> clashes;
  std::size_t pairs = 0;  // pairs whose boxes come as near as the clearance; all others are further apart
  bool complete = true;   // false: stopped before all pairs were measured
};

/// Measures all pairs of parts that have geometry. Throws nothing, allocates, starts threads.
ClashReport findClashes(const haptics::ContactScene& contact, const ClashOptions& options);

/// Measures one pair at given poses, however far apart. Nothing if a part has no geometry.
std::optional<Clash> measurePair(const PartClosings& closings, PartId a, const Pose& worldFromA, PartId b,
                                 const Pose& worldFromB);

/// The nearest neighbour of a part (`a` of the result) at these poses (one a part), among parts that may
/// collide with it. If it overlaps any, the first one found, with its depth. Nothing if the part has no
/// geometry or is alone.
std::optional<Clash> nearestPart(const PartClosings& closings, PartId part,
                                 std::span<const Pose> worldFromPart);

}  // namespace tandem::client
