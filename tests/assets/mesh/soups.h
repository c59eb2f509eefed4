#pragma once

// Small triangle soups whose topology is known.

#include <cmath>
#include <cstdint>
#include <vector>

#include "assets/mesh/mesh_analysis.h"

namespace tandem::assets::test {

inline void addTriangle(TriangleSoup& soup, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), {a, b, c});
  soup.triangles.push_back({first, first + 1, first + 2});
  soup.triangleMaterial.push_back(0);
}

inline void addQuad(TriangleSoup& soup, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                    const glm::dvec3& d) {
  addTriangle(soup, a, b, c);
  addTriangle(soup, a, c, d);
}

/// A box, every face with corners of its own, facing outward.
inline void addBox(TriangleSoup& soup, const glm::dvec3& low, const glm::dvec3& high) {
  const auto corner = [&](int i) {
    return glm::dvec3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
  };
  constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : kFaces) addQuad(soup, corner(f[0]), corner(f[1]), corner(f[2]), corner(f[3]));
}

inline TriangleSoup box(const glm::dvec3& low, const glm::dvec3& high) {
  TriangleSoup soup;
  addBox(soup, low, high);
  return soup;
}

inline void flip(TriangleSoup& soup, std::size_t triangle) {
  std::swap(soup.triangles[triangle][1], soup.triangles[triangle][2]);
}

inline void flipAll(TriangleSoup& soup, std::size_t first = 0) {
  for (std::size_t t = first; t < soup.triangles.size(); ++t) flip(soup, t);
}

/// A sphere of rings x 2 rings quads, every triangle with corners of its own as in STL, rounded to float.
inline TriangleSoup sphere(double radius, int rings) {
  TriangleSoup soup;
  const auto point = [&](int ring, int segment) {
    const double polar = M_PI * ring / rings;
    const double turn = M_PI * (segment % (2 * rings)) / rings;
    if (ring == 0 || ring == rings) return glm::dvec3(0.0, 0.0, ring == 0 ? radius : -radius);
    return glm::dvec3(glm::vec3(radius * std::sin(polar) * std::cos(turn),
                                radius * std::sin(polar) * std::sin(turn), radius * std::cos(polar)));
  };
  for (int r = 0; r < rings; ++r) {
    for (int s = 0; s < 2 * rings; ++s) {
      if (r > 0) addTriangle(soup, point(r, s), point(r + 1, s), point(r, s + 1));
      if (r + 1 < rings) addTriangle(soup, point(r, s + 1), point(r + 1, s), point(r + 1, s + 1));
    }
  }
  return soup;
}

/// A strip of n quads, closed with `halfTwists` half turns.
inline TriangleSoup ribbon(int n, int halfTwists) {
  TriangleSoup soup;
  const auto rim = [&](int i, double side) {
    const double turn = 2.0 * M_PI * i / n, twist = 0.5 * halfTwists * turn;
    const double radius = 1.0 + 0.2 * side * std::cos(twist);
    return glm::dvec3(radius * std::cos(turn), radius * std::sin(turn), 0.2 * side * std::sin(twist));
  };
  for (int i = 0; i < n; ++i) addQuad(soup, rim(i, -1), rim(i, 1), rim(i + 1, 1), rim(i + 1, -1));
  return soup;
}

inline TriangleSoup scaled(TriangleSoup soup, double scale) {
  for (glm::dvec3& p : soup.positions) p *= scale;
  return soup;
}

}  // namespace tandem::assets::test
