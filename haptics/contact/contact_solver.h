#pragma once

// The displacements of the parts that move here in one step: as near to where momentum, the hand and gravity
// would take them as contacts and joints allow.
//
//     minimise sum_b 1/2 (u_b - u0_b)^T A_b (u_b - u0_b)    subject to the rows of contact_rows.h
//
// with u_b = (t, w) the displacement of body b, u0 the free one, and A its inertia with the implicit springs
// of its coupling (virtual_coupling.h). The dual active-set method of Goldfarb & Idnani 1983, "A numerically
// stable dual method for solving strictly convex quadratic programs": from the free minimum the equations of
// joints, then the most violated row are made active, one after the other, and rows that begin to pull are
// let go; it ends at the one solution, in a handful of rows. Rows that are not exact yet are refined when
// they are violated, at the displacement that then stands, so that of thousands of candidates some dozens are
// looked at closely. A spring is a compliant row: it has one more unknown of its own, with which the method
// is the same.
//
// Friction: the point of each active row is to stay where it was when the tick began, by a force across the
// normal of at most the coefficient times the normal one (Coulomb's disc). Normal and friction forces are
// solved for in turn until they agree: staggered projections (Kaufman, Sueda, James & Pai 2008), from those
// of the last tick; the last word is the normals', so that friction never pushes anything into a surface.
//
// A part that is squeezed between others which come nearer than it is wide cannot be outside of all of them.
// Rows that contradict each other then ask only that nothing goes in deeper, which standing still does: a way
// out of the one that leads into the other would be taken back in the next step, for ever.
//
// 1. Bounded work: at most as many rows as the caller allows are refined or made active.
// 2. No allocation.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "haptics/contact/contact_rows.h"

namespace tandem::haptics {

inline constexpr int kMostBodies = 8;

/// A quadratic bowl over the displacements of a body: its minimum, and A = L L^T as the lower triangle L, row
/// by row.
struct StepGoal {
  Displacement free;    // u0
  Displacement before;  // displacement in this tick so far: friction works against that too
  std::array<std::array<double, 6>, 6> root{};  // L; kg/s^2 and so on, scaled as the caller likes
};

/// The bodies whose relative motion the rows of a pair constrain.
struct RowPair {
  int first = 0;                    // body
  int second = -1;                  // the other one; -1: it does not give way
  glm::dvec3 apart{0.0, 0.0, 0.0};  // m, from the second one's reference point to the first one's
};

/// The motion of a pair's first body, seen from the other.
inline Displacement seenFrom(const Displacement& first, const Displacement& second, const glm::dvec3& apart) {
  return {first.linear - second.at(apart), first.angular - second.angular};
}

/// Looks closely at a sample, at the displacement of its pair that the solver has reached: adds its exact
/// rows.
class RowRefiner {
 public:
  virtual void refine(RowSource source, const Displacement& u, ContactRows& rows) = 0;
  /// How far the surface under a row of a pair without a second body has gone in this tick, m, world axes.
  virtual glm::dvec3 surfaceMotion(const ExactRow& row) const = 0;

 protected:
  ~RowRefiner() = default;
};

class ContactSolver {
 public:
  static constexpr int kMostActive = 48;
  using Vector6 = std::array<double, 6>;
  using Vectors = std::array<Vector6, kMostBodies>;

  /// A direction in the space of all bodies: L^-1 (n, r x n + m) in those of one pair.
  struct Direction {
    int body[2] = {0, -1};
    Vector6 of[2];
  };
  struct ActiveRow {
    int row = -1;  // of ContactRows::exact()
    Direction direction;
    double bound = 0.0;  // direction . y + give multiplier >= bound
    double give = 0.0;
    double multiplier = 0.0;  // A (u - u0) = sum multiplier (n, r x n + m) + friction
    bool bothWays = false;
  };

  /// Friction at the point of a row.
  struct Friction {
    RowSource source;
    glm::dvec3 force{0.0, 0.0, 0.0};  // as a multiplier, world, across the normal
    bool sticks = false;
  };

  /// A goal a body, at most kMostBodies. `tolerance`: m, by how much a row may be violated; at most
  /// `mostPicks` rows are looked at or made active. Friction starts from what the last call found.
  void solve(std::span<const StepGoal> goals, std::span<const RowPair> pairs, double tolerance, int mostPicks,
             ContactRows& rows, RowRefiner& refiner);
  /// The friction that the next call starts from, by the numbers that its pairs have: at most kMostActive.
  void recallFriction(std::span<const Friction> known) {
    frictionCount_ = 0;
    for (const Friction& friction : known) friction_[static_cast<std::size_t>(frictionCount_++)] = friction;
  }

  /// Where the last call moved a body.
  const Displacement& displacement(int body) const { return u_[static_cast<std::size_t>(body)]; }
  /// The same, of pairs.
  PairMotions pairMotions() const { return {motion_.data(), pairs_.size()}; }
  std::span<const ActiveRow> active() const { return {active_.data(), static_cast<std::size_t>(count_)}; }
  std::span<const Friction> friction() const {
    return {friction_.data(), static_cast<std::size_t>(frictionCount_)};
  }
  int picks() const { return picks_; }
  /// Rounds between normal and friction forces in the last call.
  int rounds() const { return rounds_; }
  /// Whether picks ran out: rows may be left that the displacement violates.
  bool exhausted() const { return picks_ >= mostPicks_; }
  /// Rows that contradict the others: nothing satisfies them all.
  int infeasible() const { return infeasible_; }

 private:
  static constexpr int kMostRounds = 12;
  /// Where friction acts: an active row with the two directions across its normal.
  struct Pad {
    int row;
    double limit;  // of a force that sticks, and of one that slides: coefficient times multiplier
    double slidingLimit;
    glm::dvec3 tangent[2];
    Direction direction[2];  // L^-1 (t, r x t)
    double slip[2];          // m, of the free motion
    double force[2];
    bool sticks;
  };
  /// How the multipliers of the active rows change as another row's grows, and the way that is left for it.
  struct Step {
    std::array<double, kMostActive> rates;  // an active row
    Vectors way;                            // the row's direction less its share in the active ones
    double left;                            // square of that way, with what the rows give
  };

  /// Normal forces for a y that starts at `start`: of exact rows alone where `refiner` is null.
  void solveNormals(double tolerance, const Vectors& start, ContactRows& rows, RowRefiner* refiner);
  /// One attempt at that, which ends early where parts turn out to be squeezed.
  void obeyRows(double tolerance, ContactRows& rows, RowRefiner* refiner);
  /// Joints' equations, then rows that were active before: where several sets hold the parts alike, the same
  /// one is found.
  void takeKnown(double tolerance, ContactRows& rows);
  void take(int row, double tolerance, ContactRows& rows);
  /// The violated exact row to take next; -1 if there is none.
  int nextExact(double tolerance, const ContactRows& rows) const;
  /// Springs that would give more than they can: from now on they push with the most they have. True if any
  /// does.
  bool saturate(ContactRows& rows, Vectors& pushed);
  /// Friction for the normal forces as they are; returns its part of y, and by how much of the largest normal
  /// force any changed.
  double solveFriction(const ContactRows& rows, const RowRefiner& refiner, const Vectors& pushed,
                       Vectors& part);
  int makePads(const ContactRows& rows, const RowRefiner& refiner);
  /// What the friction of the last call gives with the rows of this one.
  void addLastFriction(const ContactRows& rows, Vectors& sum) const;

  Direction whitened(const RowPair& pair, const glm::dvec3& force, const glm::dvec3& moment) const;
  ActiveRow whiten(const ExactRow& row, int index) const;
  Step stepTowards(const ActiveRow& row);
  /// Adds a violated row to the active ones; false if that cannot be.
  bool activate(ActiveRow& row);
  /// Between a row and those that contradict it parts are squeezed: none of their pairs asks for a way out
  /// any more, which all of them can obey. False if none did.
  bool hold(const ActiveRow& row, ContactRows& rows);
  void drop(int i);
  void setToZero(Vectors& v) const;
  /// u_ and motion_ from y_.
  void updateMotions();

  std::span<const StepGoal> goals_;
  std::span<const RowPair> pairs_;
  std::array<ActiveRow, kMostActive> active_;
  std::array<ActiveRow, kMostActive> spare_;
  int mostPicks_ = 0;
  int count_ = 0, picks_ = 0, rounds_ = 0, infeasible_ = 0;
  bool squeezed_ = false;  // rows were changed: what has been solved so far is not what they ask
  // Cholesky's factors of the active directions' products, of as many rows as are known.
  std::array<std::array<double, kMostActive>, kMostActive> factor_;
  int factored_ = 0;
  Vectors y_{};  // L^T (u - u0)
  std::array<Displacement, kMostBodies> u_;
  std::array<Displacement, kMostPairs> motion_;
  std::array<Pad, kMostActive> pads_;
  std::array<Friction, kMostActive> friction_;
  int frictionCount_ = 0;
};

}  // namespace tandem::haptics
