#pragma once

// The displacements of the parts that move here in one step: as near to where momentum, the hand and gravity
// would take them as contacts and joints allow.
//
//     minimise sum_b 1/2 (u_b - u0_b)^T A_b (u_b - u0_b)    subject to the rows of contact_rows.h
//
// with u_b = (t, w) the displacement of body b, u0 the free one, and A its inertia with the implicit springs
// of its coupling (virtual_coupling.h). A dual active-set method (active_set.h) starts at the free minimum;
// the equations of joints, then the most violated row are made active, one after the other, and it ends at
// the one solution, in a handful of rows. Rows that are not exact yet are refined when they are violated, at
// the displacement that then stands, so that of thousands of candidates some dozens are queried.
//
// Normal and friction forces are solved for in turn until they agree (contact_friction.h). The normals are
// solved for last, so that friction never pushes anything into a surface.
//
// A part that is squeezed between others which come nearer to each other than it is wide cannot be outside
// of all of them. Rows that contradict each other then demand only that nothing goes in deeper, which
// standing still obeys. A displacement out of one part and into the other would be reversed in the next
// step, for ever.
//
// 1. Bounded work: at most as many rows as the caller allows are refined or made active.
// 2. No allocation.

#include <span>

#include "haptics/solver/active_set.h"
#include "haptics/solver/contact_friction.h"
#include "haptics/solver/contact_rows.h"
#include "haptics/solver/row_refiner.h"
#include "haptics/solver/step_space.h"

namespace tandem::haptics {

class ContactSolver {
 public:
  /// A goal a body, at most kMaxBodies. `tolerance`: m, by how much a row may be violated; at most
  /// `maxIterations` rows are refined or made active. Friction starts from what the last call found.
  void solve(std::span<const StepGoal> goals, std::span<const RowPair> pairs, double tolerance,
             int maxIterations, ContactRows& rows, RowRefiner& refiner);
  /// The friction that the next call starts from, by the numbers that its pairs have: at most
  /// ActiveSet::kMaxRows.
  void recallFriction(std::span<const FrictionForce> known) { friction_.recall(known); }

  /// The displacement of a body by the last call.
  const Displacement& displacement(int body) const { return space_.displacement(body); }
  /// The same, of pairs.
  PairMotions pairMotions() const { return space_.pairMotions(); }
  const ActiveSet::Rows& active() const { return active_.rows(); }
  std::span<const FrictionForce> friction() const { return friction_.forces(); }
  int iterations() const { return iterations_; }
  /// Rounds between normal and friction forces in the last call.
  int rounds() const { return rounds_; }
  /// Whether the iterations ran out: rows may be left that the displacement violates.
  bool exhausted() const { return iterations_ >= maxIterations_; }
  /// Rows that contradict the others: nothing satisfies them all.
  int infeasible() const { return infeasible_; }

 private:
  static constexpr int kMaxRounds = 12;

  /// Normal forces for a y that starts at `start`, again as long as parts turn out to be squeezed.
  void solveNormals(const BodyVectors& start, ContactRows& rows, RowRefiner& refiner);
  /// Warm start: joints' equations, then the rows that were active before. Where several sets of rows hold
  /// the parts alike, the same one is found again.
  void restoreActive(ContactRows& rows);
  /// Makes violated rows active until none is left; ends early where parts turn out to be squeezed.
  void obeyRows(ContactRows& rows, RowRefiner& refiner);
  /// Makes the row of a sample exact; whether u violates what it has become.
  bool refine(RowSource source, PairMotions u, ContactRows& rows, RowRefiner& refiner);
  /// Names to the refiner the balls that the present displacements violate, from the index `ball` on and at
  /// most RowRefiner::kMostAhead. Returns how many.
  int prepareBalls(int ball, const ContactRows& rows, RowRefiner& refiner) const;
  /// Makes candidates exact until an exact row is violated; false if no candidate is violated.
  bool refineViolated(ContactRows& rows, RowRefiner& refiner);
  /// The same for planes beside which a part may touch.
  bool refineBeside(ContactRows& rows, RowRefiner& refiner);
  /// Makes one exact row active, or finds that it contradicts those that are.
  void enforce(int row, ContactRows& rows);
  ActiveSet::Row activeRowOf(const ExactRow& row, int index) const;
  /// The violated exact row to make active next; -1 if there is none.
  int nextExact(const ContactRows& rows) const;
  /// Springs beyond their greatest force leave the rows and push with that force from now on. True if any
  /// does.
  bool saturate(ContactRows& rows, BodyVectors& saturated);

  StepSpace space_;
  ActiveSet active_;
  ActiveSet::Conflict conflict_;
  ContactFriction friction_;
  double tolerance_ = 0.0;  // m
  int maxIterations_ = 0;
  int iterations_ = 0, rounds_ = 0, infeasible_ = 0;
  bool squeezed_ = false;  // rows have changed, and the solution so far is not theirs
};

}  // namespace tandem::haptics
