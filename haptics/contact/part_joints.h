#pragma once

// The joints of a scene that constrain moving parts, with their state from tick to tick.
//
// 1. The joints of a control are left out: a control has its own mechanics (controls.h).
// 2. Only the constructor allocates.

#include <cstdint>
#include <span>
#include <vector>

#include "haptics/base/fault.h"
#include "haptics/contact/contact_island.h"
#include "haptics/solver/joint_rows.h"

namespace tandem::haptics {

class PartJoints {
 public:
  PartJoints(const assets::Scene& scene, FaultLatch& fault);

  bool joined(PartId part) const { return !of(part).empty(); }
  /// Indices of the joints of a part.
  std::span<const std::uint32_t> of(PartId part) const {
    return part < jointsOf_.size() ? std::span<const std::uint32_t>(jointsOf_[part])
                                   : std::span<const std::uint32_t>();
  }
  /// The part that a joint connects to this one; kNoPart is the world.
  PartId otherPart(std::uint32_t joint, PartId part) const {
    const assets::Joint& ends = *joints_[joint].joint;
    return ends.partA == part ? ends.partB : ends.partA;
  }
  /// Whether the joint may move parts by itself: by a drive, a detent or a soft limit.
  bool sprung(std::uint32_t joint) const { return joints_[joint].sprung; }
  /// False where a joint between two parts keeps them from colliding.
  bool letTouch(PartId a, PartId b) const;

  /// Measures the joints of a part anew, which another site may have moved meanwhile. Screws keep their
  /// full turns.
  void restart(PartId part);
  /// Adds the rows of the island's joints for a step within a tick of dt seconds.
  void addRows(const ContactIsland& island, double dt, ContactRows& rows);
  /// The position of a joint in m along its X axis, or in rad about it with full turns counted, as of the
  /// last tick in which one of its parts moved here.
  double value(std::uint32_t joint, bool angular) const;

 private:
  struct JointRecord {
    const assets::Joint* joint = nullptr;
    JointState state;
    bool started = false;
    bool sprung = false;
    PlacedJoint placed;
  };

  FaultLatch& fault_;
  std::vector<JointRecord> joints_;                   // one a joint of the scene
  std::vector<std::vector<std::uint32_t>> jointsOf_;  // one list a part; empty where the scene has no joint
};

}  // namespace tandem::haptics
