#pragma once

// The space in which a contact step is solved: displacements of all bodies, scaled such that the cost of
// contact_solver.h is a plain sum of squares.
//
// With A_b = L_b L_b^T (Cholesky) and y_b = L_b^T (u_b - u0_b),
//     sum_b 1/2 (u_b - u0_b)^T A_b (u_b - u0_b) = 1/2 |y|^2
// and a row with the Jacobian J demands d . y >= -gap - J u0 with the direction d = L^-1 J^T. Goldfarb &
// Idnani 1983 work in the same coordinates.
//
// 1. Holds no row. Goals and pairs must outlive their use. 2. Free of allocation.

#include <array>
#include <cstddef>
#include <span>

#include "haptics/solver/contact_rows.h"

namespace tandem::haptics {

inline constexpr int kMaxBodies = 8;

/// A quadratic bowl over the displacements of a body: its minimum, and A = L L^T as the lower triangle L, row
/// by row.
struct StepGoal {
  Displacement free;     // u0
  Displacement applied;  // displacement in this tick so far: friction works against that too
  std::array<std::array<double, 6>, 6> root{};  // L; kg/s^2 and so on, scaled as the caller likes
};

/// The bodies whose relative motion the rows of a pair constrain.
struct RowPair {
  int first = 0;                     // body
  int second = -1;                   // the other body; -1: a surface that does not give way
  glm::dvec3 offset{0.0, 0.0, 0.0};  // m, from the second body's reference point to the first one's
};

/// The displacement of a pair's first body relative to the second one.
inline Displacement relativeDisplacement(const Displacement& first, const Displacement& second,
                                         const glm::dvec3& offset) {
  return {first.linear - second.at(offset), first.angular - second.angular};
}

using Vector6 = std::array<double, 6>;
/// A vector of the whole space: six coordinates y_b for each body.
using BodyVectors = std::array<Vector6, kMaxBodies>;

inline double dot(const Vector6& a, const Vector6& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < 6; ++k) sum += a[k] * b[k];
  return sum;
}

/// The direction d = L^-1 J^T of a row with the Jacobian J: nonzero for the bodies of its pair only.
struct RowDirection {
  int body[2] = {0, -1};
  Vector6 of[2];

  double dot(const RowDirection& other) const {
    double sum = 0.0;
    for (int i = 0; i < 2 && body[i] >= 0; ++i) {
      for (int j = 0; j < 2 && other.body[j] >= 0; ++j) {
        if (body[i] == other.body[j]) sum += haptics::dot(of[i], other.of[j]);
      }
    }
    return sum;
  }
  double dot(const BodyVectors& y) const {
    double sum = 0.0;
    for (int i = 0; i < 2 && body[i] >= 0; ++i)
      sum += haptics::dot(of[i], y[static_cast<std::size_t>(body[i])]);
    return sum;
  }
  /// sum += factor d
  void addTo(BodyVectors& sum, double factor) const {
    for (int i = 0; i < 2 && body[i] >= 0; ++i) {
      Vector6& at = sum[static_cast<std::size_t>(body[i])];
      for (std::size_t k = 0; k < 6; ++k) at[k] += factor * of[i][k];
    }
  }
};

class StepSpace {
 public:
  /// At most kMaxBodies goals and kMaxPairs pairs.
  void begin(std::span<const StepGoal> goals, std::span<const RowPair> pairs);

  std::size_t bodyCount() const { return goals_.size(); }
  const RowPair& pair(std::size_t i) const { return pairs_[i]; }
  const StepGoal& goal(int body) const { return goals_[static_cast<std::size_t>(body)]; }

  /// The direction of a generalised force on a pair's first body, which acts on the second one with the
  /// opposite sign. The moment is about the first body's reference point.
  RowDirection direction(const RowPair& pair, const glm::dvec3& force, const glm::dvec3& moment) const;
  /// The free relative displacement of a pair, that of y = 0.
  Displacement freeMotion(const RowPair& pair) const;

  void setToZero(BodyVectors& v) const {
    for (std::size_t b = 0; b < goals_.size(); ++b) v[b].fill(0.0);
  }
  /// Updates the displacements of bodies and pairs to those of y.
  void moveTo(const BodyVectors& y);
  /// The displacement u_b of a body, as of the last moveTo().
  const Displacement& displacement(int body) const { return u_[static_cast<std::size_t>(body)]; }
  /// The same of all pairs, relative to their second bodies.
  PairMotions pairMotions() const { return {motion_.data(), pairs_.size()}; }

 private:
  std::span<const StepGoal> goals_;
  std::span<const RowPair> pairs_;
  std::array<Displacement, kMaxBodies> u_;
  std::array<Displacement, kMaxPairs> motion_;
};

}  // namespace tandem::haptics
