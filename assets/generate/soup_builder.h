#pragma once

// Triangles under construction, out of rings of points around the z axis.

#include <cmath>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "assets/generate/triangulate.h"
#include "assets/mesh/mesh_analysis.h"

namespace tandem::generate {

/// Points counter-clockwise around the z axis, seen from +z.
using Ring = std::vector<glm::dvec3>;

struct SoupBuilder {
  enum class Facing { up, down };

  assets::TriangleSoup soup;

  void triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    soup.positions.insert(soup.positions.end(), {a, b, c});
    soup.triangles.push_back({first, first + 1, first + 2});
    soup.triangleMaterial.push_back(0);
  }
  /// Corners counter-clockwise seen from outside.
  void quad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }
  /// Joins rings of as many points, each to the next. Outside is to the right of the way, seen with z up and
  /// the radius to the right: going up makes a shaft, going down a hole.
  void bands(const std::vector<Ring>& rings) {
    for (std::size_t k = 0; k + 1 < rings.size(); ++k) {
      const Ring &a = rings[k], &b = rings[k + 1];
      for (std::size_t i = 0; i < a.size(); ++i) {
        const std::size_t j = (i + 1) % a.size();
        quad(a[i], a[j], b[j], b[i]);
      }
    }
  }
  /// Joins a ring to one point.
  void fan(const Ring& ring, const glm::dvec3& apex, Facing facing) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const std::size_t j = (i + 1) % ring.size();
      if (facing == Facing::up)
        triangle(apex, ring[i], ring[j]);
      else
        triangle(apex, ring[j], ring[i]);
    }
  }
  /// A prism over a counter-clockwise polygon of the x-y plane, from z = 0 to `height` in `layers`. Caps use
  /// the polygon's corners only.
  void prism(const std::vector<glm::dvec2>& outline, double height, int layers) {
    std::vector<Ring> rings(static_cast<std::size_t>(layers) + 1);
    for (std::size_t i = 0; i < rings.size(); ++i) {
      for (const glm::dvec2& p : outline)
        rings[i].emplace_back(p, height * static_cast<double>(i) / static_cast<double>(layers));
    }
    bands(rings);
    for (const auto& t : triangulate(outline, {})) {
      triangle({t[0], height}, {t[1], height}, {t[2], height});
      triangle({t[0], 0.0}, {t[2], 0.0}, {t[1], 0.0});
    }
  }
  /// The flat face between two rings, one around the other, whose angles grow from point to point, whatever
  /// their counts.
  void annulus(const Ring& inner, const Ring& outer, Facing facing) {
    const double start = angleOf(inner[0]);
    const std::size_t shift = nearestTo(outer, start);
    const std::vector<double> innerAngles = unwrapped(inner, 0, start);
    const std::vector<double> outerAngles = unwrapped(outer, shift, start);
    std::size_t i = 0, j = 0;
    while (i < inner.size() || j < outer.size()) {
      const glm::dvec3 &a = inner[i % inner.size()], &b = outer[(shift + j) % outer.size()];
      const bool outwards =
          i == inner.size() || (j < outer.size() && outerAngles[j + 1] < innerAngles[i + 1]);
      const glm::dvec3& c = outwards ? outer[(shift + j + 1) % outer.size()] : inner[(i + 1) % inner.size()];
      if (facing == Facing::up)
        triangle(a, b, c);
      else
        triangle(a, c, b);
      ++(outwards ? j : i);
    }
  }

 private:
  static constexpr double kTurn = 6.283185307179586;

  static double angleOf(const glm::dvec3& p) { return std::atan2(p.y, p.x); }

  /// Angles of a ring's points from its `first` one once around, counted on from `start`.
  static std::vector<double> unwrapped(const Ring& ring, std::size_t first, double start) {
    std::vector<double> angles{std::remainder(angleOf(ring[first]) - start, kTurn)};
    for (std::size_t k = 1; k <= ring.size(); ++k) {
      const double angle = angleOf(ring[(first + k) % ring.size()]);
      const double before = angleOf(ring[(first + k - 1) % ring.size()]);
      angles.push_back(angles.back() + std::remainder(angle - before, kTurn));
    }
    return angles;
  }
  static std::size_t nearestTo(const Ring& ring, double angle) {
    const auto off = [&](std::size_t k) { return std::abs(std::remainder(angleOf(ring[k]) - angle, kTurn)); };
    std::size_t best = 0;
    for (std::size_t k = 1; k < ring.size(); ++k) {
      if (off(k) < off(best)) best = k;
    }
    return best;
  }
};

}  // namespace tandem::generate
