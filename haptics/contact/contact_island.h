#pragma once

// The moving parts that are solved together, and the pairs in which they may touch or are joined.
//
// 1. The island alone writes the poses, goals and pairs of its bodies; everyone else reads them.
// 2. Filling it and moving it is free of allocation.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "haptics/base/fault.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/contact/moving_part.h"
#include "haptics/scene/contact_world.h"
#include "haptics/scene/part_model.h"
#include "haptics/solver/step_space.h"

namespace tandem::haptics {

/// One moving part of an island.
struct ContactBody {
  PartId part = kNoPart;
  const PartModel* model = nullptr;  // null: only joints constrain it
  glm::dvec3 centreOfMass{0.0};      // m, part frame
  double radius = 0.0;               // m, about the centre of mass
  Pose pose;                         // world, now
  glm::dvec3 centre{0.0};            // of mass, m, world, as of the last place()
  Displacement goal;                 // where it would go in this tick without contacts and joints
  double mass = 1.0;                 // kg
  FixedVector<GripPace, kHands> grips;
  std::optional<AxisLimits> axis;  // of a control

  /// m, an upper bound of how far a displacement moves any point of the body.
  double motion(const Displacement& u) const;
  /// m that an exit from another part may cover in a tick. The part's own radius takes half a second, so
  /// that the hand feels a growing pull and no blow.
  double escapeDistance(double dt) const { return 2.0 * radius * dt; }
};

/// Two parts that may touch, or that a joint connects, or a part and its own axis. The first one moves here.
struct ContactPair {
  static constexpr std::int32_t kTouch = -1;  // in place of a joint: the parts may touch
  static constexpr std::int32_t kAxis = -2;   // the same: the first part's own axis

  int first = 0, second = -1;  // bodies of the island; second is -1 where the other part does not move here
  PartId other = kNoPart;      // kNoPart: the world, of a joint or an axis
  const PartModel* model = nullptr;  // of the other part
  Pose otherFromFirst;               // part frames, as of the last place()
  double push = 0.0;                 // m by which the other part's own motion may close the gap in this tick
  double gap = 0.0;                  // m, a lower bound when the tick began
  std::int32_t joint = kTouch;       // index of the scene's joint; kTouch, kAxis

  bool isJoint() const { return joint >= 0; }
  bool mayTouch() const { return joint == kTouch; }
  /// m by which the two parts may approach each other in a step that takes no body further than `reach` m.
  double closing(double reach) const { return second >= 0 ? 2.0 * reach : reach; }
};

class ContactIsland {
 public:
  ContactIsland(const ContactWorld& world, FaultLatch& fault) : world_(world), fault_(fault) {}

  // Filling: clear(), addBody() for each body, then clearPairs() and addPair().

  void clear();
  /// There must be fewer than kMaxBodies.
  ContactBody& addBody(PartId part, const glm::dvec3& centreOfMass, const Pose& pose);
  /// Adds a part with its goal of a tick of dt seconds.
  const ContactBody& addMoving(const MovingPart& part, double dt);
  void clearPairs();
  /// Where there are more pairs than fit, those with the smallest gaps stay and overflowed() becomes true.
  void addPair(const ContactPair& pair);
  /// Other parts may push a body by at least this many metres in this tick.
  void raisePush(double distance);

  // Moving.

  /// Sets the free displacement of each body to what is left of its goal; returns the longest motion, m.
  double updateGoals();
  /// Brings centres of mass and relative poses of all pairs up to date with the bodies' poses.
  void place();
  /// Scales what each body still has to go in this tick by a share, 0..1, as if so much less time were left.
  void shortenGoals(double share);
  /// Moves a body by u, from its pose at the last place().
  void moveBody(int body, const Displacement& u);

  // Reading.

  int bodyCount() const { return static_cast<int>(bodies_.size()); }
  int pairCount() const { return static_cast<int>(pairs_.size()); }
  const ContactBody& body(int i) const { return bodies_[static_cast<std::size_t>(i)]; }
  const ContactPair& pair(int i) const { return pairs_[static_cast<std::size_t>(i)]; }
  std::span<const ContactPair> pairs() const { return {pairs_.data(), pairs_.size()}; }
  const ContactBody& first(const ContactPair& pair) const { return body(pair.first); }
  /// The index of the body of a part; -1 if the part does not move here.
  int bodyOf(PartId part) const;
  /// The pose of a pair's other part, or of the world.
  const Pose& otherPose(const ContactPair& pair) const;
  /// The displacement of a body in this tick so far.
  const Displacement& applied(int body) const { return goals_[static_cast<std::size_t>(body)].applied; }
  /// What is left of a body's goal.
  Displacement remaining(int body) const;
  /// The same of a pair's first body relative to the other part.
  Displacement relativeApplied(int pair) const;
  Displacement relativeRemaining(int pair) const;
  std::span<const StepGoal> goals() const { return {goals_.data(), goals_.size()}; }
  std::span<const RowPair> rowPairs() const { return {rowPairs_.data(), rowPairs_.size()}; }
  /// m, the finest tolerance of the bodies' models.
  double tolerance() const { return tolerance_; }
  /// m, an upper bound of how far other parts may push a body in this tick.
  double push() const { return push_; }
  const Sections& sections() const { return world_.sections(); }
  /// Whether addPair() has dropped a pair since clearPairs().
  bool overflowed() const { return overflowed_; }

 private:
  static constexpr int kForJoints = 16;  // pairs that only joints may take

  Displacement relative(int pair, const Displacement& first, const Displacement& second) const;

  const ContactWorld& world_;
  FaultLatch& fault_;
  FixedVector<ContactBody, kMaxBodies> bodies_;
  FixedVector<StepGoal, kMaxBodies> goals_;  // one a body
  FixedVector<ContactPair, kMaxPairs> pairs_;
  FixedVector<RowPair, kMaxPairs> rowPairs_;  // one a pair
  double tolerance_ = 0.0;
  double push_ = 0.0;
  bool overflowed_ = false;
};

}  // namespace tandem::haptics
