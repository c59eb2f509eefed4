#include "haptics/scene/cube_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace tandem::haptics {
namespace {

constexpr int kSteps = 4;  // iterations of Frank & Wolfe
/// Heights further from the nearest point than this many times the wanted error belong to another sheet of
/// the surface.
constexpr double kWindow = 3.0;

/// Cosine of the angle beyond which the mean of the faces' normals is no plane through them.
constexpr double kLeastCosine = 0.5;

/// Relative magnitude below which the sign of an edge function is unreliable.
constexpr double kSure = 1e-9;

glm::dvec3 unitOrZero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0.0 ? v / length : glm::dvec3(0.0);
}

double manhattan(const glm::dvec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

glm::dvec3 farCorner(const glm::dvec3& direction, double half) {
  return {std::copysign(half, direction.x), std::copysign(half, direction.y),
          std::copysign(half, direction.z)};
}

/// Square of the distance from the origin to the segment a b.
double segmentSquare(const glm::dvec2& a, const glm::dvec2& b) {
  const glm::dvec2 along = b - a;
  const double square = glm::dot(along, along);
  const double t = square > 0.0 ? std::clamp(-glm::dot(a, along) / square, 0.0, 1.0) : 0.0;
  const glm::dvec2 nearest = a + t * along;
  return glm::dot(nearest, nearest);
}

double crossOf(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

/// Whether a line along g meets a triangle: 1 or -1 by the side that it faces, 0 not, `unsure` if too near to
/// an edge.
int meets(const std::array<glm::dvec2, 3>& corners, const glm::dvec2& line, bool& unsure) {
  int turns = 0;
  for (std::size_t e = 0; e < 3; ++e) {
    const glm::dvec2 a = corners[e] - line, b = corners[(e + 1) % 3] - line;
    const double turn = crossOf(a, b);
    const double scale = glm::dot(a, a) + glm::dot(b, b);
    // Too near to the edge's line, and to the edge itself, to decide.
    if (std::abs(turn) <= kSure * scale && segmentSquare(a, b) <= kSure * scale) unsure = true;
    turns += turn > 0.0 ? 1 : -1;
  }
  return turns == 3 ? 1 : turns == -3 ? -1 : 0;
}

/// One attempt to fit a cube: a direction, and the bounds of the distance along it.
class FieldFit {
 public:
  /// `facing` is that of MeshSides; `touching` says that the surface may pass the cube.
  FieldFit(const FieldCube& cube, const MeshPoint& nearest, const glm::dvec3& along, double facing,
           bool touching, double enough, double limit)
      : cube_(cube),
        nearest_(nearest),
        g_(along),
        facing_(facing),
        touching_(touching),
        enough_(enough),
        limit_(limit) {
    const glm::dvec3 axis = std::abs(g_.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    e1_ = glm::normalize(glm::cross(g_, axis));
    e2_ = glm::cross(g_, e1_);
    reach_ = cube.half * manhattan(g_);
    double least = 1e300;
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) least = std::min(least, std::abs(g_.x + y * g_.y + z * g_.z));
    footprint_ = cube.half * std::sqrt(3.0 - least * least);
    middle_ = low_ = high_ = columnLow_ = columnHigh_ = glm::dot(g_, nearest.point - cube.centre);
    lines_ = {glm::dvec2(0.0), 0.43 * footprint_ * glm::dvec2(0.8, 0.6),
              0.43 * footprint_ * glm::dvec2(-0.28, 0.96)};
  }

  /// Includes a triangle in the bounds; false if the wanted error is out of reach.
  bool add(const Triangle& t, const MeshSides& sides, std::uint32_t index) {
    const std::array<glm::dvec3, 3> v = {t.a - cube_.centre, t.b - cube_.centre, t.c - cube_.centre};
    const std::array<double, 3> z = {glm::dot(g_, v[0]), glm::dot(g_, v[1]), glm::dot(g_, v[2])};
    const double lowest = std::min({z[0], z[1], z[2]}), highest = std::max({z[0], z[1], z[2]});
    if (highest > high_) high_ = std::max(high_, above(t, g_, highest, high_));
    if (touching_ && lowest < low_) low_ = std::min(low_, -above(t, -g_, -lowest, -low_));
    if (high_ - low_ > 2.0 * limit_) return false;
    const double window = kWindow * limit_;
    const bool otherSheet = lowest > middle_ + window || highest < middle_ - window;
    if (column_ && !(otherSheet && (!touching_ || lowest > reach_ || highest < -reach_)))
      addToColumn(v, z, {sides.openEdge(index, 0), sides.openEdge(index, 1), sides.openEdge(index, 2)});
    return true;
  }

  /// Mean of the unit normals of the triangles of the column, or zero.
  const glm::dvec3& normals() const { return normals_; }

  /// The model of d, positive along g; false if there is none. `t` is the nearest triangle.
  bool finish(const Triangle& t, CubeModel& model) {
    const bool lowKnown = columnHolds();
    if (touching_) {
      if (!lowKnown) return false;
      high_ = std::max(high_, columnHigh_);
      low_ = std::min(low_, columnLow_);
    } else {
      if (high_ > -reach_) return false;
      low_ = lowKnown && columnHigh_ < -reach_ ? columnLow_ : -1e300;
      const auto raise = [this](const auto& closest) {
        if (high_ - low_ > 2.0 * enough_) low_ = std::max(low_, -farthestRise(closest));
      };
      raise([this](const glm::dvec3&) { return nearest_.point; });
      raise([&t](const glm::dvec3& p) { return closestPointOnTriangle(p, t).point; });
      low_ = std::min(low_, high_);
    }
    model.gradient = g_;
    model.value = -0.5 * (low_ + high_);
    model.error = 0.5 * (high_ - low_);
    return true;
  }

 private:
  /// A height h such that the distance of the triangle is at least g . (x - c) - h in the cube; at most
  /// `highest`, and no tighter than `enough`.
  double above(const Triangle& t, const glm::dvec3& g, double highest, double enough) const {
    const double half = cube_.half;
    const glm::dvec3 closest = closestPointOnTriangle(cube_.centre, t).point - cube_.centre;
    glm::dvec3 y = glm::clamp(closest + 4.0 * half * g, glm::dvec3(-half), glm::dvec3(half));
    double best = highest;
    for (int step = 0; step < kSteps; ++step) {
      const glm::dvec3 from = cube_.centre + y;
      const glm::dvec3 offset = from - closestPointOnTriangle(from, t).point;
      const double distance = glm::length(offset);
      if (distance <= 0.0) break;
      const glm::dvec3 m = offset / distance;
      best = std::min(best, half * manhattan(m - g) + glm::dot(m, y) - distance);
      if (best <= enough) break;
      const glm::dvec3 corner = farCorner(g - m, half);
      y += (corner - y) * (2.0 / (step + 2));
    }
    return best;
  }

  /// The largest d - z of a convex part of the surface over the cube; `closest` gives its point nearest to p.
  template <typename Closest>
  double farthestRise(const Closest& closest) const {
    double largest = -1e300;
    for (int i = 0; i < 8; ++i) {
      const glm::dvec3 x((i & 1) != 0 ? cube_.half : -cube_.half, (i & 2) != 0 ? cube_.half : -cube_.half,
                         (i & 4) != 0 ? cube_.half : -cube_.half);
      const glm::dvec3 p = cube_.centre + x;
      largest = std::max(largest, glm::distance(p, closest(p)) - glm::dot(g_, x));
    }
    return largest;
  }

  void addToColumn(const std::array<glm::dvec3, 3>& v, const std::array<double, 3>& z,
                   const std::array<bool, 3>& open) {
    std::array<glm::dvec2, 3> flat;
    for (std::size_t i = 0; i < 3; ++i) flat[i] = {glm::dot(e1_, v[i]), glm::dot(e2_, v[i])};
    const double square = footprint_ * footprint_;
    std::array<double, 3> edgeSquares;
    int turns = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      edgeSquares[e] = segmentSquare(flat[e], flat[(e + 1) % 3]);
      turns += crossOf(flat[e], flat[(e + 1) % 3]) > 0.0 ? 1 : -1;
    }
    const bool over = turns == 3 || turns == -3;
    if (!over && std::min({edgeSquares[0], edgeSquares[1], edgeSquares[2]}) > square) return;
    double lowest = std::min({z[0], z[1], z[2]}), highest = std::max({z[0], z[1], z[2]});
    const glm::dvec3 area = glm::cross(v[1] - v[0], v[2] - v[0]);
    const double steep = glm::dot(area, g_), size = glm::length(area);
    if (std::abs(steep) > 0.1 * size) {
      const double mid = glm::dot(area, v[0]) / steep;
      const double slope = std::sqrt(std::max(0.0, size * size - steep * steep)) / std::abs(steep);
      lowest = std::max(lowest, mid - slope * footprint_);
      highest = std::min(highest, mid + slope * footprint_);
    }
    const double window = kWindow * limit_;
    if (lowest > middle_ + window || highest < middle_ - window) {
      // A triangle of another sheet matters only if it may separate points of a cube that the surface passes.
      if (touching_ && lowest <= reach_ && highest >= -reach_) column_ = false;
      return;
    }
    columnLow_ = std::min(columnLow_, lowest);
    columnHigh_ = std::max(columnHigh_, highest);
    if (columnLow_ <= middle_ - window || columnHigh_ >= middle_ + window) column_ = false;
    for (std::size_t e = 0; e < 3; ++e)
      if (open[e] && edgeSquares[e] <= square) column_ = false;
    for (std::size_t i = 0; i < lines_.size(); ++i) crossings_[i] += meets(flat, lines_[i], unsure_[i]);
    if (size > 0.0) normals_ += area / size;
  }

  /// Whether all lines through the cube cross the surface between columnLow_ and columnHigh_.
  bool columnHolds() const {
    if (!column_) return false;
    // The column must lie within the ball whose triangles are known.
    const double known = nearest_.distance + 2.0 * cube_.radius();
    const double farthest = std::max(std::abs(columnLow_), std::abs(columnHigh_)) + 0x1p-20 * cube_.half;
    if (footprint_ * footprint_ + farthest * farthest >= known * known) return false;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (unsure_[i]) continue;
      return touching_ ? crossings_[i] == static_cast<int>(facing_) : crossings_[i] % 2 != 0;
    }
    return false;
  }

  const FieldCube& cube_;
  const MeshPoint& nearest_;
  glm::dvec3 g_, e1_, e2_;
  double facing_;
  bool touching_;
  double enough_;           // m, sufficient error
  double limit_;            // m
  double reach_ = 0.0;      // m, highest point of the cube
  double footprint_ = 0.0;  // m, radius of a cylinder along g that contains the cube
  double middle_ = 0.0;     // m, height of the nearest point
  double low_ = 0.0, high_ = 0.0, columnLow_ = 0.0, columnHigh_ = 0.0;  // m, heights
  bool column_ = true;
  std::array<glm::dvec2, 3> lines_;
  std::array<int, 3> crossings_{};
  std::array<bool, 3> unsure_{};
  glm::dvec3 normals_{0.0, 0.0, 0.0};
};

}  // namespace

bool CubeFit::parts(const FieldCube& cube, const MeshPoint& nearest, const CubeModel& model) const {
  if (sides_.isRegular(cube.centre, nearest.distance + 2.0 * cube.radius())) return true;
  const double off = 2.0 * model.error + 0x1p-10 * cube.half;
  const glm::dvec3 foot = cube.centre - model.value * model.gradient;
  const MeshSides::Side above = sides_.sideAt(foot + off * model.gradient, 2.0 * cube.radius());
  if (!above.certain || above.sign < 0.0) return false;
  const MeshSides::Side below = sides_.sideAt(foot - off * model.gradient, 2.0 * cube.radius());
  return below.certain && below.sign < 0.0;
}

bool CubeFit::fit(const FieldCube& cube, std::span<const std::uint32_t> near, const MeshPoint& nearest,
                  double side, double enough, double limit, CubeModel& model) const {
  const glm::dvec3 outwards = unitOrZero(sides_.outwards(nearest));
  if (outwards == glm::dvec3(0.0)) return false;
  const glm::dvec3 off = cube.centre - nearest.point;
  // Away from the surface for a cube off it, outwards for a cube on it.
  glm::dvec3 away = glm::dot(outwards, off) >= 0.0 ? outwards : -outwards;
  if (!nearest.onFace && nearest.distance > 0x1p-20 * cube.half) away = off / nearest.distance;
  const bool touching = nearest.distance <= cube.half * manhattan(away);
  if (touching && !sides_.solid()) return false;
  glm::dvec3 along = touching ? outwards : away;
  const Triangle nearestTriangle = tree_.triangle(nearest.triangle);
  bool found = false;
  for (int round = 0; round < 2; ++round) {
    FieldFit attempt(cube, nearest, along, sides_.facing(), touching, enough, limit);
    for (const std::uint32_t t : near) {
      if (!attempt.add(tree_.triangle(t), sides_, t)) return found;
    }
    CubeModel candidate;
    if (attempt.finish(nearestTriangle, candidate) && candidate.error < model.error &&
        (!touching || parts(cube, nearest, candidate))) {
      const double sign = touching ? 1.0 : side;
      model = {sign * candidate.gradient, sign * candidate.value, candidate.error};
      found = true;
    }
    const glm::dvec3 mean = unitOrZero(attempt.normals());
    const double turn = glm::dot(mean, along);
    if ((found && model.error <= enough) || std::abs(turn) < kLeastCosine) break;
    if (touching && turn * sides_.facing() < 0.0) break;
    along = turn < 0.0 ? -mean : mean;
  }
  return found;
}

}  // namespace tandem::haptics
