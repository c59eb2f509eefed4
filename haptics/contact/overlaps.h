#pragma once

// Overlaps that parts have when they begin to move here: the file has them at rest, and parts are never
// ejected. Each overlap may stay as deep as it is and no deeper, and shrinks as the parts come out of each
// other. A part that lies wholly inside another is moved out along the shortest path.
//
// A plug in a hollow seat that is too small for it is an interference fit: it goes out along its seat and in
// again, also after it has been out (interference_fit.h).
//
// 1. Alone owns the overlaps, and the depth of each pair in the present step.
// 2. Free of allocation.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "assets/scene/scene.h"
#include "haptics/base/fault.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/contact/contact_island.h"
#include "haptics/fit/interference_fit.h"
#include "haptics/fit/overlap_measure.h"
#include "haptics/solver/contact_rows.h"

namespace tandem::haptics {

/// How deep the samples of one part may be in another one, the target, in float.
struct AllowedDepth {
  /// A lower bound, m, for all samples that are at most `radius` (m) from a place, which is given in the
  /// frame of their part and relative to the origin of the target's field.
  float least(const glm::vec3& inSampled, const glm::vec3& inTarget, float radius) const;

  /// Whether only the depth differs.
  bool sameBoxes(const AllowedDepth& other) const;

  float depth = 0.0f;   // m, where either part was in the other
  float margin = 0.0f;  // m beside that, over which it falls to 0
  // m: boxes around where samples were inside, as their middles and halves.
  glm::vec3 sampledMiddle{0.0f}, sampledHalf{0.0f}, targetMiddle{0.0f}, targetHalf{0.0f};
};

class Overlaps {
 public:
  /// Alone allocates.
  Overlaps(const ContactIsland& island, FaultLatch& fault)
      : island_(island), fault_(fault), fits_(new std::optional<InterferenceFit>[kMaxFits]) {}

  // When a part begins to move here.

  /// Forgets the overlaps of a part; fits stay, and what it passes through.
  void forget(PartId part);
  /// The fit of two parts, if one is known.
  OverlapMeasure::KnownFit knownFit(PartId first, PartId other) const;
  /// Remembers the overlap of two parts as it has been measured, with its fit or null. Parts that pass
  /// through each other go on to, unless they have parted. The oldest overlap is forgotten where there is no
  /// room.
  void remember(PartId first, PartId other, const MeasuredOverlap& measured, const InterferenceFit* fit);
  /// From now on two parts pass through each other, until no sample of one is near the other.
  void letPass(PartId first, PartId other);
  /// Whether a part passes through another one.
  bool passes(PartId part) const;

  // In a step, in this order: beginStep(); noteDepth() for each pair; endStep().

  /// Finds the overlap of each pair of the island.
  void beginStep();
  /// An upper bound of how deep the samples of one part of a pair are in the other now, m.
  void noteDepth(int pair, double depth);
  /// Lets overlaps shrink to what they are now, and forgets those that have ended.
  void endStep();

  /// Whether the parts of a pair were in each other when one began to move here.
  bool has(int pair) const { return of_[static_cast<std::size_t>(pair)] >= 0; }
  /// The interference fit of a pair, or null; in `firstIsHollow`, whether the pair's first part has the seat.
  const InterferenceFit* fit(int pair, bool& firstIsHollow) const;
  /// Whether one part of the pair was wholly inside the other: instead of contact rows the pair has an exit
  /// row.
  bool contained(int pair) const;
  /// Whether the parts of the pair pass through each other.
  bool passing(int pair) const { return has(pair) && overlapOf(pair).passing; }
  /// m by which a sample of either part may be deep in the other, at a place that is given in both part
  /// frames. It is the whole depth where either part was in the other, and falls to 0 beside that.
  double allowedAt(int pair, const glm::dvec3& inFirst, const glm::dvec3& inOther) const;
  /// The same for the samples of the pair's first part, or of the other one, before the field of its partner,
  /// which has this origin.
  AllowedDepth allowed(int pair, bool ofFirst, const glm::dvec3& fieldOrigin) const;
  /// The row that moves the contained part of a pair out, in a tick of dt seconds.
  ExactRow exitRow(int pair, double dt) const;
  /// m, the longest exit of any contained body of the island in a tick of dt seconds; 0 if none is
  /// contained.
  double longestExit(double dt) const;

 private:
  static constexpr std::size_t kMaxOverlaps = 64, kMaxFits = 32;
  static constexpr int kNoFit = -1;

  /// Two parts that were in each other when one began to move here.
  struct Overlap {
    PartId a = kNoPart, b = kNoPart;
    double allowed = 0.0;            // m, how deep it may be; shrinks as they come out
    assets::Bounds inA, inB;         // m, part frames: where samples were inside
    double margin = 0.0;             // m beside the bounds, over which the allowed depth falls to 0
    bool contained = false;          // a is wholly inside b
    bool passing = false;            // of letPass(); bounds and depth mean nothing
    glm::dvec3 exit{0.0, 0.0, 0.0};  // unit, in the frame of b
    int fit = kNoFit;                // into fits_
    bool aIsHollow = false;          // of a fit
  };
  const Overlap& overlapOf(int pair) const;
  bool isOf(const Overlap& overlap, PartId one, PartId other) const {
    return (overlap.a == one && overlap.b == other) || (overlap.b == one && overlap.a == other);
  }
  const Overlap* fitted(PartId one, PartId other) const;
  int freeFit() const;

  const ContactIsland& island_;
  FaultLatch& fault_;
  FixedVector<Overlap, kMaxOverlaps> overlaps_;
  std::unique_ptr<std::optional<InterferenceFit>[]> fits_;  // kMaxFits; the storage of none is not written
  // Of the present step, one a pair of the island.
  std::array<int, kMaxPairs> of_{};          // into overlaps_; -1: none
  std::array<double, kMaxPairs> deepest_{};  // m, an upper bound
};

}  // namespace tandem::haptics
