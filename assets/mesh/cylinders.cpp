#include "assets/mesh/cylinders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "assets/base/across.h"
#include "assets/base/constants.h"
#include "assets/base/disjoint_sets.h"

namespace tandem::assets {
namespace {

constexpr double kFlat = 1e-3;            // rad: facets that turn by less are one plane
constexpr double kMaxTurn = 0.251 * kPi;  // rad
constexpr double kParallel = 5e-3;        // rad
constexpr double kAlike = 0.25;           // turns that differ by this share belong to one cylinder
constexpr double kAround = 0.9 * kPi;     // rad that a cylinder must go around
constexpr double kFull = 0.7;             // least total length of the edges, relative to edges of full length
constexpr double kOffCircle = 0.05;       // of the sag, by which edges may be off the circle
constexpr double kRounding = 1e-5;        // of the radius, the same: coordinates are single precision

/// An edge across which the surface turns a little.
struct Roll {
  glm::dvec3 a{0.0}, b{0.0};  // m, its ends
  glm::dvec3 direction{0.0};  // unit
  double turn = 0.0;          // rad; below 0 where the surface is hollow
};

bool alike(const Roll& l, const Roll& r) {
  return std::abs(l.turn - r.turn) < kAlike * std::max(std::abs(l.turn), std::abs(r.turn)) &&
         glm::length(glm::cross(l.direction, r.direction)) < kParallel;
}

class CylinderFinder {
 public:
  explicit CylinderFinder(const Mesh& mesh) : mesh_(mesh), rollOf_(mesh.triangles.size(), kNoRolls) {}

  std::vector<Cylinder> find() {
    if (mesh_.neighbours.size() != mesh_.triangles.size()) return {};
    measureNormals();
    findRolls();
    DisjointSets cylinders = joinRolls();
    std::map<std::uint32_t, std::vector<std::uint32_t>> groups;
    for (std::uint32_t i = 0; i < rolls_.size(); ++i) groups[cylinders.find(i)].push_back(i);
    std::vector<Cylinder> found;
    for (const auto& [root, rolls] : groups)
      if (rolls.size() >= 4) fit(rolls, found);
    return found;
  }

 private:
  static constexpr std::array<std::uint32_t, 3> kNoRolls{kNone, kNone, kNone};

  const glm::dvec3& corner(std::uint32_t triangle, std::size_t i) const {
    return mesh_.positions[mesh_.triangles[triangle][i % 3]];
  }

  void measureNormals() {
    normals_.resize(mesh_.triangles.size(), glm::dvec3(0.0));
    for (std::uint32_t t = 0; t < normals_.size(); ++t) {
      const glm::dvec3 n = glm::cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
      if (const double length = glm::length(n); length > 0.0) normals_[t] = n / length;
    }
  }

  double turnBetween(std::uint32_t a, std::uint32_t b) const {
    return std::atan2(glm::length(glm::cross(normals_[a], normals_[b])), glm::dot(normals_[a], normals_[b]));
  }
  bool degenerate(std::uint32_t triangle) const { return normals_[triangle] == glm::dvec3(0.0); }

  void findRolls() {
    for (std::uint32_t t = 0; t < normals_.size(); ++t)
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t other = mesh_.neighbours[t][e];
        if (other == kNone || other < t || degenerate(t) || degenerate(other)) continue;
        const double turn = turnBetween(t, other);
        if (turn < kFlat || turn > kMaxTurn) continue;
        Roll roll{corner(t, e), corner(t, e + 1), {}, turn};
        roll.direction = glm::normalize(roll.b - roll.a);
        // Over a ridge the neighbour's normal leans away from this triangle, in a hollow towards it.
        if (glm::dot(normals_[other], corner(t, e + 2) - roll.a) > 0.0) roll.turn = -turn;
        const auto index = static_cast<std::uint32_t>(rolls_.size());
        rolls_.push_back(roll);
        rollOf_[t][e] = index;
        for (std::size_t back = 0; back < 3; ++back)
          if (mesh_.neighbours[other][back] == t) rollOf_[other][back] = index;
      }
  }

  /// Joins the edges on both sides of a facet: those of a triangle and of the triangles in its plane.
  DisjointSets joinRolls() {
    DisjointSets cylinders(rolls_.size());
    for (std::uint32_t t = 0; t < normals_.size(); ++t) {
      std::array<std::uint32_t, 9> near{};
      std::size_t count = 0;
      const auto add = [&](std::uint32_t triangle) {
        for (const std::uint32_t roll : rollOf_[triangle])
          if (roll != kNone && count < near.size()) near[count++] = roll;
      };
      add(t);
      for (const std::uint32_t other : mesh_.neighbours[t])
        if (other != kNone && !degenerate(other) && turnBetween(t, other) < kFlat) add(other);
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = 0; k < i; ++k)
          if (alike(rolls_[near[i]], rolls_[near[k]])) cylinders.join(near[i], near[k]);
    }
    return cylinders;
  }

  void fit(const std::vector<std::uint32_t>& rolls, std::vector<Cylinder>& found) const {
    Cylinder cylinder;
    cylinder.axis = glm::dvec3(0.0);
    double turn = 0.0;
    glm::dvec3 mean(0.0);
    for (const std::uint32_t i : rolls) {
      const Roll& roll = rolls_[i];
      cylinder.axis += glm::dot(roll.direction, cylinder.axis) < 0.0 ? -roll.direction : roll.direction;
      turn += std::abs(roll.turn) / static_cast<double>(rolls.size());
      mean += 0.5 * (roll.a + roll.b) / static_cast<double>(rolls.size());
    }
    cylinder.axis = glm::normalize(cylinder.axis);
    cylinder.segments = static_cast<int>(std::lround(2.0 * kPi / turn));
    cylinder.hollow = rolls_[rolls.front()].turn < 0.0;
    const auto [x, y] = acrossOf(cylinder.axis);
    glm::dvec2 centre(0.0);
    if (!fitCircle(rolls, mean, x, y, centre, cylinder.radius)) return;
    cylinder.middle = mean + x * centre.x + y * centre.y;
    if (isOne(rolls, x, y, turn, cylinder)) found.push_back(cylinder);
  }

  /// Least squares of x^2 + y^2 = 2 x cx + 2 y cy + k (Kasa 1976), about `mean`.
  bool fitCircle(const std::vector<std::uint32_t>& rolls, const glm::dvec3& mean, const glm::dvec3& x,
                 const glm::dvec3& y, glm::dvec2& centre, double& radius) const {
    glm::dmat3 normal(0.0);
    glm::dvec3 right(0.0);
    for (const std::uint32_t i : rolls)
      for (const glm::dvec3& end : {rolls_[i].a, rolls_[i].b}) {
        const glm::dvec3 row(glm::dot(end - mean, x), glm::dot(end - mean, y), 1.0);
        const double square = row.x * row.x + row.y * row.y;
        for (int c = 0; c < 3; ++c) normal[c] += row * row[c];
        right += row * square;
      }
    const glm::dvec3 solved = glm::inverse(normal) * right;
    centre = 0.5 * glm::dvec2(solved.x, solved.y);
    const double square = solved.z + glm::dot(centre, centre);
    radius = square > 0.0 ? std::sqrt(square) : 0.0;
    return std::isfinite(radius) && radius > 0.0;
  }

  /// Whether all edges lie on the circle and go around far enough; measures its length.
  bool isOne(const std::vector<std::uint32_t>& rolls, const glm::dvec3& x, const glm::dvec3& y, double turn,
             Cylinder& cylinder) const {
    const double tolerance = kOffCircle * cylinder.sag() + kRounding * cylinder.radius;
    double low = 1e300, high = -1e300, length = 0.0;
    std::vector<double> angles;
    for (const std::uint32_t i : rolls) {
      length += glm::length(rolls_[i].b - rolls_[i].a);
      for (const glm::dvec3& end : {rolls_[i].a, rolls_[i].b}) {
        const glm::dvec3 from = end - cylinder.middle;
        const glm::dvec2 flat(glm::dot(from, x), glm::dot(from, y));
        if (std::abs(glm::length(flat) - cylinder.radius) > tolerance) return false;
        low = std::min(low, glm::dot(from, cylinder.axis));
        high = std::max(high, glm::dot(from, cylinder.axis));
        angles.push_back(std::atan2(flat.y, flat.x));
      }
    }
    std::sort(angles.begin(), angles.end());
    double around = turn;  // the facets before the first and after the last edge, half of each
    double before = angles.back() - 2.0 * kPi;
    for (const double angle : angles) {
      if (angle - before > 0.5 * turn && angle - before < 1.5 * turn) around += turn;
      before = angle;
    }
    cylinder.middle += cylinder.axis * (0.5 * (low + high));
    cylinder.halfLength = 0.5 * (high - low);
    // A lune of a sphere is similar to a cylinder, except that its edges become shorter.
    return around >= kAround && length * turn > kFull * around * (high - low);
  }

  const Mesh& mesh_;
  std::vector<glm::dvec3> normals_;                   // one a triangle; 0 where it has none
  std::vector<std::array<std::uint32_t, 3>> rollOf_;  // one an edge of a triangle, into rolls_
  std::vector<Roll> rolls_;
};

}  // namespace

double Cylinder::sag() const { return radius * (1.0 - std::cos(kPi / segments)); }

std::vector<Cylinder> findCylinders(const Mesh& mesh) { return CylinderFinder(mesh).find(); }

}  // namespace tandem::assets
