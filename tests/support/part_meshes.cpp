#include "tests/support/part_meshes.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/constants.h"
#include "assets/generate/triangulate.h"
#include "tests/support/soup_builder.h"

namespace tandem::test {
namespace {

int eights(int segments) { return std::max(8, (segments + 7) / 8 * 8); }

Ring circle(double radius, double z, int segments) {
  Ring ring;
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * kPi * i / segments;
    ring.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return ring;
}

/// As many points on a square's sides, in the same directions; its corners are among them.
Ring square(double half, double z, int segments) {
  Ring ring;
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * kPi * i / segments;
    const double c = std::cos(angle), s = std::sin(angle);
    const bool corner = i % (segments / 4) == segments / 8;
    const double x = corner || std::abs(c) > std::abs(s) ? std::copysign(half, c) : half * c / std::abs(s);
    const double y = corner || std::abs(s) > std::abs(c) ? std::copysign(half, s) : half * s / std::abs(c);
    ring.emplace_back(x, y, z);
  }
  return ring;
}

}  // namespace

Facets facetsFor(int triangles) {
  const int segments =
      eights(static_cast<int>(2.24 * std::sqrt(static_cast<double>(std::max(triangles, 300)))));
  return {segments, std::max(1, triangles / (2 * segments) - 2)};
}

double chordSag(double radius, int segments) { return radius * (1.0 - std::cos(kPi / segments)); }

int segmentsNeeded(double radius, double clearance) {
  return static_cast<int>(std::ceil(kPi / std::sqrt(clearance / radius)));
}

assets::TriangleSoup pegSoup(const Peg& peg) {
  const int n = eights(peg.facets.segments);
  SoupBuilder b;
  std::vector<Ring> rings;
  if (peg.chamfer > 0.0) rings.push_back(circle(peg.radius - peg.chamfer, 0.0, n));
  for (int i = 0; i <= peg.facets.rings; ++i) {
    const double z = peg.chamfer + (peg.length - peg.chamfer) * i / peg.facets.rings;
    rings.push_back(circle(peg.radius, z, n));
  }
  b.fan(rings.front(), {0.0, 0.0, 0.0}, SoupBuilder::Facing::down);
  b.bands(rings);
  b.fan(rings.back(), {0.0, 0.0, peg.length}, SoupBuilder::Facing::up);
  return b.soup;
}

assets::TriangleSoup boredBlockSoup(const BoredBlock& block) {
  const int n = eights(block.facets.segments);
  const double out = block.fit == Fit::around ? 1.0 / std::cos(kPi / n) : 1.0;
  const bool through = block.depth >= block.height;
  SoupBuilder b;
  std::vector<Ring> rings{square(0.5 * block.width, -block.height, n), square(0.5 * block.width, 0.0, n)};
  if (block.chamfer > 0.0) rings.push_back(circle(out * (block.boreRadius + block.chamfer), 0.0, n));
  for (int i = 0; i <= block.facets.rings; ++i) {
    const double z = -block.chamfer - (block.depth - block.chamfer) * i / block.facets.rings;
    rings.push_back(circle(out * block.boreRadius, z, n));
  }
  if (through) rings.push_back(rings.front());
  b.bands(rings);
  if (!through) {
    b.fan(rings.front(), {0.0, 0.0, -block.height}, SoupBuilder::Facing::down);
    b.fan(rings.back(), {0.0, 0.0, -block.depth}, SoupBuilder::Facing::up);
  }
  return b.soup;
}

assets::TriangleSoup boxSoup(const glm::dvec3& size, int n) {
  SoupBuilder b;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto at = [&](int i, int j) {
        glm::dvec3 p;
        p[axis] = 0.5 * side * size[axis];
        p[u] = size[u] * (static_cast<double>(i) / n - 0.5) * side;
        p[v] = size[v] * (static_cast<double>(j) / n - 0.5);
        return p;
      };
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) b.quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
  }
  return b.soup;
}

assets::TriangleSoup ballSoup(double radius, const Facets& facets) {
  const int n = eights(facets.segments);
  SoupBuilder b;
  std::vector<Ring> rings;
  for (int i = 1; i < facets.rings; ++i) {
    const double polar = kPi * i / facets.rings;
    rings.push_back(circle(radius * std::sin(polar), -radius * std::cos(polar), n));
  }
  b.fan(rings.front(), {0.0, 0.0, -radius}, SoupBuilder::Facing::down);
  b.bands(rings);
  b.fan(rings.back(), {0.0, 0.0, radius}, SoupBuilder::Facing::up);
  return b.soup;
}

assets::TriangleSoup prismSoup(const std::vector<glm::dvec2>& outline, double height, int layers) {
  SoupBuilder b;
  b.prism(outline, height, layers);
  return b.soup;
}

namespace {

/// A prism over an outline of the x-z plane (counter-clockwise with x to the right and z up), along y around
/// the origin.
assets::TriangleSoup prismAlongY(const std::vector<glm::dvec2>& outline, double length) {
  assets::TriangleSoup soup = prismSoup(outline, length);
  for (glm::dvec3& p : soup.positions) p = {p.x, 0.5 * length - p.z, p.y};
  return soup;
}

}  // namespace

assets::TriangleSoup vGrooveSoup(double depth, double halfAngle, double land, double length) {
  const double half = depth * std::tan(halfAngle), outer = half + land;
  return prismAlongY({{0.0, 0.0},
                      {-half, depth},
                      {-outer, depth},
                      {-outer, -depth},
                      {outer, -depth},
                      {outer, depth},
                      {half, depth}},
                     length);
}

assets::TriangleSoup slotSoup(double width, double depth, double wall, double length) {
  const double half = 0.5 * width, outer = half + wall;
  return prismAlongY({{-half, 0.0},
                      {-half, depth},
                      {-outer, depth},
                      {-outer, -wall},
                      {outer, -wall},
                      {outer, depth},
                      {half, depth},
                      {half, 0.0}},
                     length);
}

assets::TriangleSoup stairSoup(int steps, double run, double rise, double length) {
  std::vector<glm::dvec2> outline{{0.0, 0.0}, {steps * run, 0.0}};
  for (int i = steps; i > 0; --i) {
    outline.emplace_back(i * run, i * rise);
    outline.emplace_back((i - 1) * run, i * rise);
  }
  return prismAlongY(outline, length);
}

std::vector<glm::dvec2> spurGearOutline(const SpurGear& gear) {
  const double pitch = 0.5 * gear.module * gear.teeth, base = pitch * std::cos(gear.pressureAngle);
  const double tip = pitch + gear.module, root = pitch - 1.25 * gear.module;
  const auto involute = [](double angle) { return std::tan(angle) - angle; };
  const auto halfAngleAt = [&](double r) {
    return 0.5 * kPi / gear.teeth - 0.5 * gear.backlash / pitch + involute(gear.pressureAngle) -
           involute(std::acos(std::min(1.0, base / r)));
  };
  const double start = std::max(base, root), atStart = halfAngleAt(start);
  // The foot leans outwards a little where a cutter would leave a fillet.
  const double atRoot = start > root ? atStart + 0.3 * (kPi / gear.teeth - atStart) : atStart;
  std::vector<glm::dvec2> outline;
  for (int tooth = 0; tooth < gear.teeth; ++tooth) {
    const double centre = 2.0 * kPi * tooth / gear.teeth;
    const auto add = [&](double r, double angle) {
      outline.emplace_back(r * std::cos(centre + angle), r * std::sin(centre + angle));
    };
    const auto radiusAt = [&](int i) { return start + (tip - start) * i / (gear.flankPoints - 1); };
    if (start > root) add(root, -atRoot);
    for (int i = 0; i < gear.flankPoints; ++i) add(radiusAt(i), -halfAngleAt(radiusAt(i)));
    for (int i = gear.flankPoints; i-- > 0;) add(radiusAt(i), halfAngleAt(radiusAt(i)));
    if (start > root) add(root, atRoot);
  }
  return outline;
}

assets::TriangleSoup spurGearSoup(const SpurGear& gear) {
  const std::vector<glm::dvec2> outline = spurGearOutline(gear);
  Ring low, high;
  for (const glm::dvec2& p : outline) {
    low.emplace_back(p, 0.0);
    high.emplace_back(p, gear.width);
  }
  const int n = eights(4 * gear.teeth);
  const Ring holeLow = circle(gear.bore, 0.0, n), holeHigh = circle(gear.bore, gear.width, n);
  SoupBuilder b;
  b.bands({low, high});
  b.bands({holeHigh, holeLow});
  b.annulus(holeHigh, high, SoupBuilder::Facing::up);
  b.annulus(holeLow, low, SoupBuilder::Facing::down);
  return b.soup;
}

assets::TriangleSoup insideOut(assets::TriangleSoup soup) {
  for (auto& t : soup.triangles) std::swap(t[1], t[2]);
  return soup;
}

assets::TriangleSoup shattered(const assets::TriangleSoup& soup, int flipEvery, int dropEvery) {
  SoupBuilder b;
  int index = 0;
  for (const auto& t : soup.triangles) {
    ++index;
    if (dropEvery > 0 && index % dropEvery == 0) continue;
    const bool flip = flipEvery > 0 && index % flipEvery == 0;
    b.triangle(soup.positions[t[0]], soup.positions[t[flip ? 2 : 1]], soup.positions[t[flip ? 1 : 2]]);
  }
  return b.soup;
}

assets::TriangleSoup moved(assets::TriangleSoup soup, const glm::dvec3& by) {
  for (glm::dvec3& p : soup.positions) p += by;
  return soup;
}

assets::TriangleSoup joined(assets::TriangleSoup first, const assets::TriangleSoup& second) {
  const auto base = static_cast<std::uint32_t>(first.positions.size());
  first.positions.insert(first.positions.end(), second.positions.begin(), second.positions.end());
  for (auto t : second.triangles) {
    for (std::uint32_t& corner : t) corner += base;
    first.triangles.push_back(t);
  }
  first.triangleMaterial.resize(first.triangles.size(), 0);
  return first;
}

assets::Mesh meshOf(assets::TriangleSoup soup) { return assets::analyseMesh(std::move(soup), 0.5).mesh; }

assets::Mesh rawMeshOf(const assets::TriangleSoup& soup) {
  assets::Mesh mesh;
  mesh.positions = soup.positions;
  mesh.triangles = soup.triangles;
  mesh.triangleMaterial = soup.triangleMaterial;
  for (const glm::dvec3& p : mesh.positions) {
    mesh.bounds.include(p);
  }
  return mesh;
}

}  // namespace tandem::test
