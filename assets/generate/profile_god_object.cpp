#include "assets/generate/profile_god_object.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::generate {
namespace {

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

}  // namespace

bool insideProfile(const std::vector<glm::dvec2>& profile, const glm::dvec2& p) {
  bool inside = false;
  for (std::size_t i = 0, j = profile.size() - 1; i < profile.size(); j = i++) {
    const glm::dvec2 &a = profile[i], &b = profile[j];
    if ((a.y > p.y) == (b.y > p.y)) continue;
    if (p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
  }
  return inside;
}

std::vector<glm::dvec2> grownProfile(const std::vector<glm::dvec2>& profile, double radius, double turn) {
  const std::size_t n = profile.size();
  const auto outward = [&](std::size_t edge) {
    const glm::dvec2 d = glm::normalize(profile[(edge + 1) % n] - profile[edge % n]);
    return glm::dvec2(d.y, -d.x);
  };
  std::vector<glm::dvec2> grown;
  for (std::size_t i = 0; i < n; ++i) {
    const glm::dvec2 before = outward(i + n - 1), after = outward(i);
    const double angle = std::atan2(cross(before, after), glm::dot(before, after));
    if (angle <= 0.0) {
      grown.push_back(profile[i] + radius * (before + after) / (1.0 + glm::dot(before, after)));
      continue;
    }
    const int pieces = std::max(1, static_cast<int>(std::ceil(angle / turn)));
    for (int k = 0; k <= pieces; ++k) {
      const double a = angle * k / pieces;
      grown.push_back(profile[i] + radius * glm::dvec2(before.x * std::cos(a) - before.y * std::sin(a),
                                                       before.x * std::sin(a) + before.y * std::cos(a)));
    }
  }
  return grown;
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
  // Each step ends at a corner or a wall and shortens the distance, so no piece is visited more than a few
  // times.
  const std::size_t maxSteps = 8 * profile_.size() + 16;
  for (std::size_t i = 0; i < maxSteps; ++i) {
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
  const glm::dvec2 displacement = goal - position_;
  double first = 1.0;
  std::size_t hit = kNothing;
  for (std::size_t e = 0; e < profile_.size(); ++e) {
    if (e == leftA_ || e == leftB_ || glm::dot(displacement, outward(e)) >= 0.0) continue;
    const double a = cross(displacement, corner(e) - position_),
                 b = cross(displacement, corner(e + 1) - position_);
    if ((a >= 0.0) == (b >= 0.0)) continue;
    const double t = glm::dot(corner(e) - position_, outward(e)) / glm::dot(displacement, outward(e));
    if (t < 0.0 || t >= first) continue;
    first = t;
    hit = e;
  }
  leftA_ = leftB_ = kNothing;
  position_ = hit == kNothing ? goal : position_ + displacement * first;
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
  const glm::dvec2 displacement = goal - position_;
  const bool offNext = glm::dot(displacement, outward(next)) > 0.0;
  const bool offPrevious = glm::dot(displacement, outward(previous)) > 0.0;
  const bool convex = cross(along(previous), along(next)) > 0.0;
  if (convex ? offNext || offPrevious : offNext && offPrevious) {
    where_ = Where::free;
    leftA_ = previous;
    leftB_ = next;
    return true;
  }
  // At a convex corner deep under the goal both walls may lead down; the god object follows the steeper one.
  // In a concave corner a wall that the goal pulls away from is not a path.
  const double forward = convex || !offNext ? glm::dot(displacement, glm::normalize(along(next))) : 0.0;
  const double backward =
      convex || !offPrevious ? -glm::dot(displacement, glm::normalize(along(previous))) : 0.0;
  if (!(std::max(forward, backward) > 0.0)) return false;
  where_ = Where::edge;
  index_ = forward >= backward ? next : previous;
  return true;
}

}  // namespace tandem::generate
