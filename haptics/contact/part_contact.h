#pragma once

// The parts that a site moves among their neighbours: where each may go in one tick.
//
// A moving part is a god object with mass: it goes where its momentum, the hand's spring, gravity, joints
// and contacts together take it, and never into a neighbour. PairFinder finds the parts that may meet,
// Islands groups those that are solved together, and ContactStep moves one island.
//
// 1. Free of allocation after construction. One a TickState; only where a scene has part models or joints.
// 2. Called by the thread that ticks, and by nobody else. The world and the fault latch must outlive it.

#include <cstdint>
#include <span>

#include "haptics/base/contact_effort.h"
#include "haptics/base/fault.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/base/tick_types.h"
#include "haptics/contact/contact_history.h"
#include "haptics/contact/contact_island.h"
#include "haptics/contact/contact_step.h"
#include "haptics/contact/moving_part.h"
#include "haptics/contact/overlaps.h"
#include "haptics/contact/pair_finder.h"
#include "haptics/contact/part_joints.h"
#include "haptics/contact/part_taking.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

class PartContact {
 public:
  /// A part that moves less than this share of its size in a second is at rest.
  static constexpr double kRestShare = 3e-3;

  using Work = ContactWork;

  PartContact(const ContactWorld& world, FaultLatch& fault);
  PartContact(const PartContact&) = delete;
  PartContact& operator=(const PartContact&) = delete;

  /// Whether a model of its shape, or a joint, constrains where a part may go.
  bool constrains(PartId part) const { return collides(part) || joined(part); }
  bool collides(PartId part) const { return world_.model(part) != nullptr; }
  bool joined(PartId part) const { return joints_.joined(part); }
  /// Calls f(other) with each part that a joint connects to this one.
  template <typename F>
  void forEachJoined(PartId part, const F& f) const {
    for (const std::uint32_t joint : joints_.of(part)) {
      const PartId other = joints_.otherPart(joint, part);
      if (other != kNoPart) f(other);
    }
  }

  /// Moves a part here from now on, from its pose in the world, once take() has taken it. No effect on a part
  /// that is being taken.
  void own(PartId part, const glm::dvec3& centreOfMass);
  /// A part does not move here any more.
  void disown(PartId part);
  /// Whether a part is being taken (part_taking.h): until that is over it must not be moved.
  bool isTaking(PartId part) const { return waitingFor(part) != nullptr; }
  /// A part that is being taken cannot stand still: the next take() takes it in a hurry.
  void hurry(PartId part);
  /// Once in each tick of dt seconds, before move(): goes on with the parts that are being taken, in the
  /// order in which they came. What takes little work is taken at once.
  void take(double dt, const ContactEffort& effort);
  /// Work that the last take() has done for parts that could stand still, in units (counted_work.h).
  int takingWork() const { return takingWork_; }
  /// Lets these threads run parts of heavy ticks (ContactStep::share()). Allocates.
  void share(TickHelpers* helpers) { step_.share(helpers); }
  /// Whether they ran parts of the last tick, because the tick before it had many rows.
  bool isShared() const { return step_.isShared(); }
  /// The world's models have been exchanged.
  void modelsChanged();

  /// Sections have moved. What they bring back of a part that moves here and of its neighbours may stay as
  /// deep in each other as it is.
  void sectionsMoved(PartId part, const glm::dvec3& centreOfMass);
  /// From now on a part that moves here passes through another one, until it has left it.
  void letPass(PartId part, PartId other);
  /// Whether it passes through any.
  bool passes(PartId part) const { return overlaps_.passes(part); }
  /// Whether a part presses at a place that sections cut away now, as of the last tick.
  bool pressesWhereCut(PartId part) const;

  /// Moves all parts that move here by one tick of dt seconds as far as their neighbours and joints let
  /// them, and gives each body the velocity of its motion. `moving` has at most kMaxBodies entries, each
  /// with a part and a body of its own.
  void move(std::span<MovingPart> moving, double dt, const ContactEffort& effort = {});

  /// Whether something moves beside a part that is at rest here, or a part that it is joined to.
  bool disturbed(PartId part) const;

  /// m, the radius of a control's part about the reference point of `body`, where one of the parts that move
  /// may touch it in a tick of dt seconds; else 0. Judged by balls, with room for what contact may do.
  double radiusNear(PartId control, const RigidBody& body, std::span<const MovingPart> moving,
                    double dt) const;
  /// Whether a part pressed on another one in the last tick.
  bool presses(PartId part) const;

  /// The touches of the last tick, strongest first.
  std::span<const PartTouch> touches() const { return touches_.all(); }
  const Work& work() const { return work_; }
  /// Position of a joint of the scene (part_joints.h).
  double jointValue(std::uint32_t joint, bool angular) const { return joints_.value(joint, angular); }

 private:
  using Moving = std::span<MovingPart* const>;

  /// A part that is being taken.
  struct Waiting {
    PartId part = kNoPart;
    glm::dvec3 centreOfMass{0.0};  // m, part frame
    bool hurried = false;
  };
  const Waiting* waitingFor(PartId part) const;
  /// Takes a part at once, as well as a limited portion of work allows.
  void takeAtOnce(const Waiting& waiting, bool exits);
  /// Makes one island of these parts.
  void gather(Moving moving);

  const ContactWorld& world_;
  FaultLatch& fault_;
  PartJoints joints_;
  PairFinder finder_;
  ContactIsland island_;  // the present one
  Overlaps overlaps_;
  ContactHistory history_;
  ContactStep step_;
  FixedVector<Waiting, kMaxOwnedParts> waiting_;
  PartTaking standing_, atOnce_;  // of the first part that waits, once begun; of one in a hurry
  bool begun_ = false;
  int takingWork_ = 0;
  PartTouches touches_;
  Work work_;
  double dt_ = 0.0;  // s, of the last tick
};

}  // namespace tandem::haptics
