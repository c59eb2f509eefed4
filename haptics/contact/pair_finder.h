#pragma once

// Which pairs of parts may touch, or are joined, within one tick: the broad phase of contact between parts.
//
// 1. It has no state of its own.

#include "haptics/contact/contact_island.h"
#include "haptics/contact/part_joints.h"

namespace tandem::haptics {

class PairFinder {
 public:
  PairFinder(const ContactWorld& world, const PartJoints& joints) : world_(world), joints_(joints) {}

  bool mayTouch(PartId a, PartId b) const;
  /// Adds the pairs of each body of the island with the parts that come within `reach` m of it in a tick of
  /// dt seconds.
  void findTouching(double reach, double dt, ContactIsland& island) const;
  /// Adds the pairs that joints connect, and those of controls with their axes.
  void findJoined(double dt, ContactIsland& island) const;

 private:
  /// An upper bound of how far any point of a part moves in a tick of dt seconds by the part's own
  /// velocity, m.
  double push(PartId part, double dt) const;
  /// A lower bound of the gap of two parts: from the box of a body to the ball around the other, m; below 0
  /// where they meet.
  double leastGap(const ContactBody& body, const Pose& bodyFromWorld, PartId other) const;

  const ContactWorld& world_;
  const PartJoints& joints_;
};

}  // namespace tandem::haptics
