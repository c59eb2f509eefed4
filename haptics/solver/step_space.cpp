#include "haptics/solver/step_space.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

/// Solves L x = (force, moment) by forward substitution.
Vector6 solveRoot(const StepGoal& goal, const glm::dvec3& force, const glm::dvec3& moment) {
  Vector6 d{force.x, force.y, force.z, moment.x, moment.y, moment.z};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t k = 0; k < i; ++k) d[i] -= goal.root[i][k] * d[k];
    d[i] /= goal.root[i][i];
  }
  return d;
}

/// u = u0 + L^-T y, by back substitution.
Displacement displacementOf(const StepGoal& goal, Vector6 y) {
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t k = i + 1; k < 6; ++k) y[i] -= goal.root[k][i] * y[k];
    y[i] /= goal.root[i][i];
  }
  return {goal.free.linear + glm::dvec3(y[0], y[1], y[2]), goal.free.angular + glm::dvec3(y[3], y[4], y[5])};
}

}  // namespace

void StepSpace::begin(std::span<const StepGoal> goals, std::span<const RowPair> pairs) {
  ASSERT(goals.size() <= u_.size() && pairs.size() <= motion_.size());
  goals_ = goals;
  pairs_ = pairs;
}

RowDirection StepSpace::direction(const RowPair& pair, const glm::dvec3& force,
                                  const glm::dvec3& moment) const {
  RowDirection d;
  d.body[0] = pair.first;
  d.body[1] = pair.second;
  d.of[0] = solveRoot(goal(pair.first), force, moment);
  if (pair.second >= 0)
    d.of[1] = solveRoot(goal(pair.second), -force, -moment - glm::cross(pair.offset, force));
  return d;
}

Displacement StepSpace::freeMotion(const RowPair& pair) const {
  const Displacement& first = goal(pair.first).free;
  return pair.second < 0 ? first : relativeDisplacement(first, goal(pair.second).free, pair.offset);
}

void StepSpace::moveTo(const BodyVectors& y) {
  for (std::size_t b = 0; b < goals_.size(); ++b) u_[b] = displacementOf(goals_[b], y[b]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const RowPair& pair = pairs_[p];
    const Displacement& first = displacement(pair.first);
    motion_[p] =
        pair.second < 0 ? first : relativeDisplacement(first, displacement(pair.second), pair.offset);
  }
}

}  // namespace tandem::haptics
