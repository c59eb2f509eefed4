#pragma once

// Coulomb friction at the active rows of a step, for given normal forces.
//
// The point of each active row is to stay where it was when the tick began, by a force f across the normal
// with |f| <= mu_s l, or mu_d l once it slides: Coulomb's disc, the section of the friction cone at the
// normal multiplier l. Projected Gauss-Seidel: contact after contact, f takes the value that stops the slip,
// and is projected onto its disc. The solver alternates this with the normal forces until they agree:
// staggered projections (Kaufman, Sueda, James & Pai 2008, "Staggered projections for frictional contact in
// multibody systems").
//
// 1. Starts from the forces of the last call, matched by the rows' sources. 2. Free of allocation.

#include <span>

#include "haptics/base/fixed_vector.h"
#include "haptics/solver/active_set.h"
#include "haptics/solver/row_refiner.h"

namespace tandem::haptics {

/// Friction at the point of a row.
struct FrictionForce {
  RowSource source;
  glm::dvec3 force{0.0, 0.0, 0.0};  // as a multiplier, world, across the normal
  bool sticks = false;
};

class ContactFriction {
 public:
  /// Replaces the forces that the next call starts from: at most ActiveSet::kMaxRows.
  void recall(std::span<const FrictionForce> known);
  std::span<const FrictionForce> forces() const { return {forces_.data(), forces_.size()}; }

  /// How much the friction forces of a call differ from those of the call before.
  struct Change {
    double force = 0.0;  // the largest change of a force, as a share of the largest normal force
    double slip = 0.0;   // m, at most how far such a change moves the point where it acts
  };

  /// Adds what the forces of the last call give with the rows of this step.
  void addTo(const StepSpace& space, const ContactRows& rows, BodyVectors& sum) const;

  /// Friction for the multipliers of the active rows. `saturated` is the share of y that comes from
  /// springs at their greatest force; `part` becomes the share that comes from friction. Returns
  /// what has changed since the last call.
  Change solve(const StepSpace& space, const ActiveSet::Rows& active, const ContactRows& rows,
               const RowRefiner& refiner, const BodyVectors& saturated, BodyVectors& part);

 private:
  /// Where friction acts: an active row with the two directions across its normal.
  struct FrictionContact {
    int row;               // of ContactRows::exact()
    double stickingLimit;  // of a force that sticks: coefficient times multiplier
    double slidingLimit;   // of a force that slides
    glm::dvec3 tangent[2];
    RowDirection direction[2];
    double mobility;  // m that a unit of force moves the point, at most
    double slip[2];   // m, of the free motion
    double force[2];
    bool sticks;
  };
  using Contacts = FixedVector<FrictionContact, ActiveSet::kMaxRows>;

  void makeContacts(const StepSpace& space, const ActiveSet::Rows& active, const ContactRows& rows,
                    const RowRefiner& refiner);
  /// Gauss-Seidel over all contacts; y follows their forces. `largest` is the largest multiplier.
  void iterate(double largest, BodyVectors& y);
  /// The last force at a row; null if there was none.
  const FrictionForce* lastAt(const RowSource& source) const;

  Contacts contacts_;
  FixedVector<FrictionForce, ActiveSet::kMaxRows> forces_;
};

}  // namespace tandem::haptics
