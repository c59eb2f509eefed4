#pragma once

// The steps of one island in a tick. Each gathers the samples that could touch within its reach, of each part
// of a pair in the field of the other, and solves for the displacements of all bodies (contact_solver.h). No
// step is longer than its reach, so that nothing is passed through unseen; what is left of a fast motion is
// made up in the next ticks.
//
// 1. Owns the rows, the solver and the samples' memory; moves the bodies of the island through the island.
// 2. Only the constructor allocates.

#include <cstdint>
#include <memory>
#include <span>

#include "haptics/base/contact_effort.h"
#include "haptics/base/fault.h"
#include "haptics/contact/contact_history.h"
#include "haptics/contact/contact_island.h"
#include "haptics/contact/moving_part.h"
#include "haptics/contact/overlaps.h"
#include "haptics/contact/part_joints.h"
#include "haptics/contact/sample_refiner.h"
#include "haptics/contact/shared_gather.h"
#include "haptics/contact/side_clocks.h"
#include "haptics/fit/counted_work.h"
#include "haptics/solver/contact_rows.h"
#include "haptics/solver/contact_solver.h"

namespace tandem::haptics {

/// What a tick spends on contact between parts, for reports.
struct ContactWork {
  int steps = 0, planes = 0, balls = 0, exact = 0, iterations = 0, infeasible = 0, neighbours = 0;
  bool overflow = false;   // rows or neighbours were dropped
  bool exhausted = false;  // the step was cut short because the iterations ran out
};

class ContactStep {
 public:
  static constexpr int kMaxSteps = 4;  // of one island in a tick

  /// The parameters that all islands of a tick share.
  struct Tick {
    double dt = 0.0;  // s
    ContactEffort effort;
    ContactWork* work = nullptr;     // to add to
    PartTouches* touches = nullptr;  // to add to
  };

  ContactStep(const ContactWorld& world, ContactIsland& island, Overlaps& overlaps, PartJoints& joints,
              ContactHistory& history, FaultLatch& fault);

  /// Lets these threads run parts of heavy ticks from now on; null: the calling thread does all. They must
  /// outlive this. Allocates.
  void share(TickHelpers* helpers);
  /// Begins a tick, after one in which `last` was done. The helpers are awake while the result lives.
  [[nodiscard]] TickHelpers::Awake beginTick(const ContactWork& last);
  bool isShared() const { return sharing_; }

  /// Moves the bodies of the island as far as contacts and joints let them, and sets poses and velocities
  /// of the parts, which stand in the same order. At most `maxIterations` rows are refined or made active.
  void move(std::span<MovingPart* const> moving, const Tick& tick, int maxIterations);

  /// Prepares the first step of an island that stands still, whose bodies are placed, with ticks of dt
  /// seconds: reads the samples that have not been read within the reach of a short step, and asks for those
  /// of which the field does not tell whether they touch. True once all have been.
  bool readAhead(double dt, const ContactEffort& effort, CountedWork& work);
  /// m, the reach by which resting contacts of an island are found.
  static double shortReach(const ContactIsland& island);

 private:
  /// Adds the candidate rows of all pairs that could touch within `reach` m.
  void gather(double reach, double dt);
  /// Those of one pair.
  void gatherPair(int pair, const SharedGather::Step& step);
  /// Adds the exact rows of the cached contacts, so that what rests stays at rest. They are queried for the
  /// remaining displacement of the bodies.
  void refineCached();
  void solve(const Tick& tick, int maxIterations);
  /// An upper bound, m, of how far other parts may push a part of the island that has a GripPace: those that
  /// move elsewhere, and bodies of the island without one, which go on as in the last tick. 0 if no part has
  /// one.
  double mayBePushed(std::span<MovingPart* const> moving, double dt) const;
  /// The share, 0..1, of the solver's displacements at which every grip keeps its GripPace.
  double paceOfStep() const;
  /// Moves the bodies by the solver's displacements, at most by the reach; true if no further step is
  /// needed.
  bool advance(bool isFirst, ContactWork& work);
  void finish(MovingPart& part, int body, bool moved, double dt) const;
  void noteTouches(const Tick& tick) const;

  ContactIsland& island_;
  Overlaps& overlaps_;
  PartJoints& joints_;
  ContactHistory& history_;
  FaultLatch& fault_;
  ContactRows rows_;
  ContactSolver solver_;
  SampleRefiner refiner_;
  SideClocks clocks_;
  std::unique_ptr<SharedGather> shared_;  // null: nothing is shared
  bool sharing_ = false;                  // in this tick
  double reach_ = 0.0;                    // m, of the present step
  double pushed_ = 0.0;                   // m, mayBePushed() of this tick
  bool slips_ = false;                    // whether a GripPace has shortened a step of this tick
  double lastMotion_ = 0.0;  // m, of the island's last step; half of what was sought where it was cut short
};

}  // namespace tandem::haptics
