#pragma once

// The steps of one island in a tick. Each gathers the samples that could touch within its reach, of each part
// of a pair in the field of the other, and solves for the displacements of all bodies (contact_solver.h). No
// step is longer than its reach, so that nothing is passed through unseen; what is left of a fast motion is
// made up in the next ticks.
//
// 1. Owns the rows, the solver and the samples' memory; moves the bodies of the island through the island.
// 2. Only the constructor allocates.

#include <cstdint>
#include <span>

#include "haptics/base/contact_effort.h"
#include "haptics/base/fault.h"
#include "haptics/contact/contact_history.h"
#include "haptics/contact/contact_island.h"
#include "haptics/contact/contact_rows.h"
#include "haptics/contact/contact_solver.h"
#include "haptics/contact/moving_part.h"
#include "haptics/contact/overlaps.h"
#include "haptics/contact/part_joints.h"
#include "haptics/contact/sample_refiner.h"

namespace tandem::haptics {

/// What a tick has spent on contact between parts, for reports.
struct ContactWork {
  int steps = 0, planes = 0, balls = 0, exact = 0, iterations = 0, infeasible = 0, neighbours = 0;
  bool overflow = false;   // rows or neighbours were dropped
  bool exhausted = false;  // the step was cut short because there was more to look at than a tick allows
};

class ContactStep {
 public:
  static constexpr int kMaxSteps = 4;  // of one island in a tick

  /// What a tick gives every island.
  struct Tick {
    double dt = 0.0;  // s
    ContactEffort effort;
    ContactWork* work = nullptr;     // to add to
    PartTouches* touches = nullptr;  // to add to
  };

  ContactStep(const ContactWorld& world, ContactIsland& island, Overlaps& overlaps, PartJoints& joints,
              ContactHistory& history, FaultLatch& fault);

  /// Moves the bodies of the island as far as contacts and joints let them, and gives the parts, which stand
  /// in the same order, their poses and velocities. At most `maxIterations` rows are looked at.
  void move(std::span<MovingPart* const> moving, const Tick& tick, int maxIterations);

 private:
  /// Rows of all pairs that could touch within `reach` m.
  void gather(double reach, double dt);
  /// Exact rows of the last steps' contacts from the start, so that what rests stays at rest. They are aimed
  /// at where the bodies are expected to go.
  void refineCached();
  void solve(const Tick& tick, int maxIterations);
  /// Moves the bodies as far as the solver said and the reach allows; true if nothing is left to do.
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
  double reach_ = 0.0;       // m, of the present step
  double lastMotion_ = 0.0;  // m, of the island's last step
};

}  // namespace tandem::haptics
