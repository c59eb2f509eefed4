#pragma once

// The active rows of a step with their multipliers: the dual active-set method of Goldfarb & Idnani 1983, "A
// numerically stable dual method for solving strictly convex quadratic programs".
//
// The point y minimises 1/2 |y - start|^2 subject to d_i . y >= bound_i for the active rows, with multipliers
// l_i >= 0 (Karush-Kuhn-Tucker):
//     y = start + sum_i l_i d_i,    d_i . y + c_i l_i = bound_i
// A row of compliance c_i > 0 is a spring: it has one more unknown of its own, s = sqrt(c_i) l_i, in which
// the method is the same.
//
// 1. Each add() keeps the conditions for the rows that are active; rows that begin to pull leave the set.
// 2. Free of allocation. It knows no contact: rows are known by a number of the caller's.

#include <array>

#include "haptics/base/fixed_vector.h"
#include "haptics/solver/step_space.h"

namespace tandem::haptics {

class ActiveSet {
 public:
  static constexpr int kMaxRows = 48;

  struct Row {
    int row = -1;  // the caller's number, of ContactRows::exact()
    RowDirection direction;
    double bound = 0.0;  // direction . y + compliance multiplier >= bound
    double compliance = 0.0;
    double multiplier = 0.0;  // A (u - u0) = sum multiplier (n, r x n + m) + friction
    bool isEquality = false;
  };
  using Rows = FixedVector<Row, kMaxRows>;
  /// The numbers of rows that cannot all be obeyed: the new one first.
  using Conflict = FixedVector<int, kMaxRows + 1>;

  /// Starts from a point without active rows; y has a vector for each of `bodies` bodies.
  void begin(std::size_t bodies, const BodyVectors& start);
  /// Lets all rows go and leaves the point where it is.
  void clear();
  /// Moves the point and leaves the rows, for a caller that reads them before it clears them.
  void moveTo(const BodyVectors& point);

  /// Makes a row active that y violates. Where it contradicts active rows nothing changes: false, and the
  /// rows that take part in the contradiction.
  bool add(Row row, Conflict& conflict);

  const Rows& rows() const { return rows_; }
  const BodyVectors& point() const { return y_; }

 private:
  /// One step of the method towards a further row: r and z of Goldfarb & Idnani 1983, section 3.
  struct Step {
    std::array<double, kMaxRows> rates;  // r: how multipliers of active rows fall as the row's own grows
    BodyVectors path;                    // z: the row's direction less its share in the active ones
    double square;                       // |z|^2 with what compliant rows add
  };

  Step stepTowards(const Row& row);
  /// Updates the Cholesky factor of the active directions' products, d_i . d_j + c_i [i = j], for new rows.
  void factor();
  bool activate(Row& row);
  void drop(std::size_t i);

  std::size_t bodies_ = 0;
  Rows rows_;
  Rows before_;  // of an add() that may fail
  std::array<std::array<double, kMaxRows>, kMaxRows> factor_;
  std::size_t factored_ = 0;  // rows of factor_ that are valid
  BodyVectors y_{};
};

}  // namespace tandem::haptics
