#include "client/report/exact_answers.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::client::report {
namespace {

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

}  // namespace

glm::dvec3 outsideSphere(const glm::dvec3& goal, double radius) {
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
  // On the nearer wall, or in the apex where the goal lies below both: by symmetry never on the farther one.
  const double up = std::max(0.0, glm::dot(g, wall));
  return {side * up * wall.x, goal.y, up * wall.y};
}

ProfileGodObject::ProfileGodObject(std::vector<glm::dvec2> profile) : profile_(std::move(profile)) {}

void ProfileGodObject::place(const glm::dvec2& position) {
  position_ = position;
  where_ = Where::free;
  leftA_ = leftB_ = kNothing;
}

glm::dvec2 ProfileGodObject::outward(std::size_t edge) const {
  const glm::dvec2 d = along(edge);
  return {d.y, -d.x};  // counter-clockwise: the solid lies to the left
}

glm::dvec2 ProfileGodObject::follow(const glm::dvec2& goal) {
  // Each step ends at a corner or a wall and the distance falls: no piece is visited more than a few times.
  const std::size_t most = 8 * profile_.size() + 16;
  for (std::size_t i = 0; i < most; ++i) {
    const bool moves = where_ == Where::free   ? stepFree(goal)
                       : where_ == Where::edge ? stepEdge(goal)
                                               : stepCorner(goal);
    if (!moves) break;
  }
  return position_;
}

/// Straight towards the goal until a wall is met from outside. Signs of whole corners decide which edges the
/// line crosses, so it cannot slip through where two meet.
bool ProfileGodObject::stepFree(const glm::dvec2& goal) {
  const glm::dvec2 way = goal - position_;
  double first = 1.0;
  std::size_t hit = kNothing;
  for (std::size_t e = 0; e < profile_.size(); ++e) {
    if (e == leftA_ || e == leftB_ || glm::dot(way, outward(e)) >= 0.0) continue;
    const double a = cross(way, corner(e) - position_), b = cross(way, corner(e + 1) - position_);
    if ((a >= 0.0) == (b >= 0.0)) continue;
    const double t = glm::dot(corner(e) - position_, outward(e)) / glm::dot(way, outward(e));
    if (t < 0.0 || t >= first) continue;
    first = t;
    hit = e;
  }
  leftA_ = leftB_ = kNothing;
  position_ = hit == kNothing ? goal : position_ + way * first;
  if (hit == kNothing) return false;
  where_ = Where::edge;
  index_ = hit;
  return true;
}

bool ProfileGodObject::stepEdge(const glm::dvec2& goal) {
  const glm::dvec2 a = corner(index_), d = along(index_);
  if (glm::dot(goal - a, outward(index_)) > 0.0) {
    where_ = Where::free;
    leftA_ = index_;
    return true;
  }
  const double s = glm::dot(goal - a, d) / glm::dot(d, d);
  if (s > 0.0 && s < 1.0) {
    position_ = a + d * s;
    return false;
  }
  where_ = Where::corner;
  index_ = (index_ + (s >= 1.0 ? 1 : 0)) % profile_.size();
  position_ = corner(index_);
  return true;
}

bool ProfileGodObject::stepCorner(const glm::dvec2& goal) {
  const std::size_t next = index_, previous = (index_ + profile_.size() - 1) % profile_.size();
  const glm::dvec2 way = goal - position_;
  const bool offNext = glm::dot(way, outward(next)) > 0.0;
  const bool offPrevious = glm::dot(way, outward(previous)) > 0.0;
  const bool convex = cross(along(previous), along(next)) > 0.0;
  if (convex ? offNext || offPrevious : offNext && offPrevious) {
    where_ = Where::free;
    leftA_ = previous;
    leftB_ = next;
    return true;
  }
  // Both ways along the walls lead down at a convex corner deep under the goal: the steeper one is taken. In
  // a concave corner a wall that the goal draws away from is no way.
  const double forward = convex || !offNext ? glm::dot(way, glm::normalize(along(next))) : 0.0;
  const double backward = convex || !offPrevious ? -glm::dot(way, glm::normalize(along(previous))) : 0.0;
  if (!(std::max(forward, backward) > 0.0)) return false;
  where_ = Where::edge;
  index_ = forward >= backward ? next : previous;
  return true;
}

}  // namespace tandem::client::report
