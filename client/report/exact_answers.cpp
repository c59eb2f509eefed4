#include "client/report/exact_answers.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "assets/base/assert.h"

namespace tandem::client::report {
glm::dvec3 outsideSphere(const glm::dvec3& goal, double radius) {
  ASSERT(radius > 0.0);
  const double distance = glm::length(goal);
  if (distance >= radius) return goal;
  return distance > 0.0 ? goal * (radius / distance) : glm::dvec3(0.0, 0.0, radius);
}

glm::dvec3 abovePlane(const glm::dvec3& goal, double height) {
  return {goal.x, goal.y, std::max(goal.z, height)};
}

glm::dvec3 insideGroove(const glm::dvec3& goal, double halfAngle) {
  const double side = goal.x < 0.0 ? -1.0 : 1.0;
  const glm::dvec2 g(std::abs(goal.x), goal.z), wall(std::sin(halfAngle), std::cos(halfAngle));
  if (g.x * wall.y <= g.y * wall.x) return goal;
  // The answer lies on the nearer wall, or in the apex where the goal lies below both walls; by symmetry
  // never on the farther wall.
  const double up = std::max(0.0, glm::dot(g, wall));
  return {side * up * wall.x, goal.y, up * wall.y};
}

}  // namespace tandem::client::report
