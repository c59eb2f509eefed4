#pragma once

// The constraints of one step of the parts that move: non-penetration of contacts and equations of joints,
// linearised as half-spaces that points of the parts must not leave.
//
// Each row belongs to a pair of parts. With u = (t, w) the displacement of the pair's first part in the
// step relative to the other part (m, and rad about the first part's reference point), row i demands
//     n_i . (t + w x r_i) >= -gap_i        r_i from the reference point, m
// What is known of its point makes a row one of three kinds. A plane comes from a field and is good to
// within the field's error. A ball stands near edges, where a field has no direction: the point may go
// `room` m in any direction before it must be queried. An exact row replaces either once the point has been
// queried; joints make exact rows from the start.
//
// 1. Fixed capacity; what does not fit is dropped and counted. Nothing allocates after construction.
// 2. Planes are floats side by side, for four-wide sums: u is a fraction of a millimetre, so that their
//    rounding is far below the error of a field.

#include <array>
#include <bitset>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "haptics/base/fixed_vector.h"

namespace tandem::haptics {

/// A displacement of a body: of its reference point in m, and a rotation vector in rad, world axes.
struct Displacement {
  glm::dvec3 linear{0.0, 0.0, 0.0};
  glm::dvec3 angular{0.0, 0.0, 0.0};

  glm::dvec3 at(const glm::dvec3& arm) const { return linear + glm::cross(angular, arm); }
};

/// Pairs that a step may have.
inline constexpr int kMaxPairs = 96;

/// Which sample of which pair of parts a row comes from.
struct RowSource {
  std::uint16_t pair = 0;  // into the pairs of this tick
  // 0: a sample of the first part; 1: of the other one; 2, 3, ...: their further planes.
  std::uint16_t side = 0;
  std::uint32_t sample = 0;
  bool operator==(const RowSource&) const = default;
};

/// A row with known Jacobian, n . (t + w x r) + m . w >= -gap: n is its linear part, r x n + m its angular
/// part. m is 0 for a contact; n is 0 for a limit of a rotation.
struct ExactRow {
  glm::dvec3 normal{0.0, 0.0, 0.0};                    // unit, world, the direction that opens the gap
  glm::dvec3 arm{0.0, 0.0, 0.0};                       // m, world axes, from the reference point
  double gap = 0.0;                                    // m
  double staticFriction = 0.0, dynamicFriction = 0.0;  // Coulomb coefficients of the pair
  RowSource source;
  glm::dvec3 angular{0.0, 0.0, 0.0};  // the angular Jacobian m beside that of the arm: m a rad of rotation
  double compliance = 0.0;            // soft constraint: m that a unit of multiplier bends it; 0 = rigid
  double maxMultiplier =
      std::numeric_limits<double>::infinity();  // greatest multiplier; beyond it the row yields
  bool isEquality = false;                      // an equation, not a half-space

  double along(const Displacement& u) const {
    return glm::dot(normal, u.at(arm)) + glm::dot(angular, u.angular);
  }
  /// How far the displacement leaves the half-space, m; at most 0 if it does not.
  double violation(const Displacement& u) const { return -gap - along(u); }
  /// Whether it is a rigid half-space that pushes the part out of a penetration.
  bool pushesOut() const { return gap < 0.0 && compliance == 0.0 && !isEquality; }
};

/// Displacements of the pairs' first parts relative to the other ones.
using PairMotions = std::span<const Displacement>;

class ContactRows {
 public:
  static constexpr int kMaxPlanes = 32768, kMaxBalls = 4096, kMaxExact = 1024;

  ContactRows();

  void clear() {
    planes_ = balls_ = exact_ = dropped_ = pairs_ = 0;
    anySoft_ = anyBeside_ = false;
    squeezed_.reset();
  }
  /// Planes and balls from here on belong to the next pair: 0, 1, ... False if there is no room for it.
  bool beginPair();
  /// `beside`: m by which the part may touch beside the place of the plane before that place does.
  void addPlane(const glm::vec3& normal, const glm::vec3& arm, float gap, RowSource source,
                float beside = 0.0f);
  void addBall(const glm::vec3& arm, float room, RowSource source);
  /// Planes and balls that have been added one after the other.
  struct Range {
    int firstPlane = 0, endPlane = 0, firstBall = 0, endBall = 0;
  };
  /// Those from here on, until end(range).
  Range begin() const { return {planes_, planes_, balls_, balls_}; }
  void end(Range& range) const {
    range.endPlane = planes_;
    range.endBall = balls_;
  }
  /// Adds those of other rows.
  void append(const ContactRows& other, const Range& range);
  /// Counts rows that others have dropped.
  void noteDropped(const ContactRows& other) { dropped_ += other.dropped_; }
  /// Returns its index, or -1 if there is no room.
  int addExact(const ExactRow& row);

  /// From now on no half-space of the pair pushes out: a point behind one may stay as deep as it is and go
  /// no deeper.
  void squeeze(int pair);
  bool isSqueezed(int pair) const { return squeezed_[static_cast<std::size_t>(pair)]; }

  /// The plane that u violates most, by more than `limit` m; -1 if none.
  int worstPlane(PairMotions u, double limit) const;
  static constexpr std::size_t kMaxBeside = 32;
  /// A plane that u obeys, and what it leaves, m.
  struct LowPlane {
    int plane = -1;
    float room = 0.0f;
  };
  using LowPlanes = FixedVector<LowPlane, kMaxBeside>;
  /// The planes, lowest first, beside which the part may touch although u obeys them.
  void lowestBeside(PairMotions u, LowPlanes& found) const;
  /// The first ball from `from` on that u leaves; -1 if none.
  int nextBall(PairMotions u, int from) const;
  /// The rigid exact row from `from` on that u violates most, by more than `limit` m; -1 if none.
  int worstExact(PairMotions u, double limit, int from = 0) const;

  /// The largest share of u, 0..1, that violates no row of those still there more than standing still does.
  double safeShare(PairMotions u) const;

  /// Removes a plane or a ball that has become an exact row, or that constrains nothing.
  void dropPlane(int i) { gap_[i] = 1e30f; }
  /// From now on the part does not touch beside the plane.
  void clearBeside(int i) { beside_[i] = 0.0f; }
  void dropBall(int i) { ball_[i].room = 1e30f; }
  void dropExact(int i) {
    rows_[i].gap = 1e30;
    rows_[i].isEquality = false;
  }

  RowSource planeSource(int i) const { return source_[i]; }
  glm::vec3 planeNormal(int i) const { return {wrench_[0][i], wrench_[1][i], wrench_[2][i]}; }
  RowSource ballSource(int i) const { return ball_[i].source; }
  const ExactRow& exact(int i) const { return rows_[i]; }
  int planes() const { return planes_; }
  int balls() const { return balls_; }
  int exactRows() const { return exact_; }
  int dropped() const { return dropped_; }
  /// Whether there are exact rows that bend.
  bool anySoft() const { return anySoft_; }

 private:
  struct Ball {
    glm::vec3 arm;
    float room;
    RowSource source;
  };

  /// The plane of one pair that u violates most, by more than -least m; -1 if none; lowers `least`.
  int worstPlaneOf(int begin, int end, const Displacement& u, float& least) const;
  int endOf(int pair) const {
    return pair + 1 < pairs_ ? firstPlane_[static_cast<std::size_t>(pair) + 1] : planes_;
  }

  std::unique_ptr<float[]> storage_;  // wrench_, gap_ and beside_ in one block
  float* wrench_[6];                  // normal, arm x normal
  float* gap_;
  float* beside_;
  std::unique_ptr<RowSource[]> source_;
  std::unique_ptr<Ball[]> ball_;
  std::unique_ptr<ExactRow[]> rows_;
  std::array<int, kMaxPairs> firstPlane_{};  // of a pair; a multiple of four
  int planes_ = 0, balls_ = 0, exact_ = 0, dropped_ = 0, pairs_ = 0;
  bool anySoft_ = false, anyBeside_ = false;
  std::bitset<kMaxPairs> squeezed_;
};

}  // namespace tandem::haptics
