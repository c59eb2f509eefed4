#pragma once

// The exact god object of a point outside a polygon: constrained descent of the distance to the goal,
// followed corner by corner. What the proxy in an extruded polygon must agree with.

#include <cmath>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace tandem::test {

class PolygonGodObject {
 public:
  /// Outline counter-clockwise; the free space is outside.
  PolygonGodObject(std::vector<glm::dvec2> outline, const glm::dvec2& start)
      : outline_(std::move(outline)), position_(start) {}

  const glm::dvec2& position() const { return position_; }

  void moveTo(const glm::dvec2& goal) {
    for (int step = 0; step < 1000; ++step) {
      if (edge_ < 0 ? fly(goal) : slide(goal)) return;
    }
  }

  static bool contains(const std::vector<glm::dvec2>& outline, const glm::dvec2& p) {
    bool inside = false;
    for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
      const glm::dvec2 &a = outline[i], &b = outline[j];
      if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) inside = !inside;
    }
    return inside;
  }

 private:
  int count() const { return static_cast<int>(outline_.size()); }
  const glm::dvec2& corner(int i) const {
    return outline_[static_cast<std::size_t>((i + count()) % count())];
  }
  glm::dvec2 along(int edge) const { return glm::normalize(corner(edge + 1) - corner(edge)); }
  glm::dvec2 outwards(int edge) const {
    const glm::dvec2 t = along(edge);
    return {t.y, -t.x};
  }

  /// Free motion to the goal or the first edge in the way; true if it arrived.
  bool fly(const glm::dvec2& goal) {
    const glm::dvec2 way = goal - position_;
    double first = 1.0;
    int hit = -1;
    for (int i = 0; i < count(); ++i) {
      if (i == left_ || i == leftToo_) continue;
      const glm::dvec2 n = outwards(i), t = corner(i + 1) - corner(i);
      const double slope = glm::dot(way, n);
      if (!(slope < 0.0)) continue;
      const double when = -glm::dot(position_ - corner(i), n) / slope;
      if (when < 0.0 || when >= first) continue;
      const double place = glm::dot(position_ + way * when - corner(i), t) / glm::dot(t, t);
      if (place < 0.0 || place > 1.0) continue;
      first = when;
      hit = i;
    }
    position_ += way * first;
    left_ = leftToo_ = -1;
    edge_ = hit;
    return hit < 0;
  }

  /// Along the present edge towards the foot of the goal; true if it rests there.
  bool slide(const glm::dvec2& goal) {
    const glm::dvec2 t = along(edge_), d = goal - position_;
    if (glm::dot(d, outwards(edge_)) >= 0.0) return leave(edge_, -1);
    const double length = glm::length(corner(edge_ + 1) - corner(edge_));
    const double place = glm::dot(goal - corner(edge_), t);
    if (place >= 0.0 && place <= length) {
      position_ = corner(edge_) + t * place;
      return true;
    }
    const bool forwards = place > length;
    const int next = (forwards ? edge_ + 1 : edge_ - 1 + count()) % count();
    position_ = corner(forwards ? edge_ + 1 : edge_);
    const glm::dvec2 rest = goal - position_;
    if (glm::dot(rest, outwards(next)) >= 0.0) return leave(edge_, next);
    const double onwards = (forwards ? 1.0 : -1.0) * glm::dot(rest, along(next));
    if (!(onwards > 0.0)) return true;  // held in a corner
    edge_ = next;
    return false;
  }

  bool leave(int edge, int too) {
    left_ = edge;
    leftToo_ = too;
    edge_ = -1;
    return false;
  }

  std::vector<glm::dvec2> outline_;
  glm::dvec2 position_;
  int edge_ = -1;                 // that it rests on
  int left_ = -1, leftToo_ = -1;  // that it is just leaving
};

}  // namespace tandem::test
