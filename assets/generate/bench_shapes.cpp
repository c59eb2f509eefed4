#include "assets/generate/bench_shapes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <glm/geometric.hpp>

namespace tandem::generate {
namespace {

using assets::TriangleSoup;

void addTriangle(TriangleSoup& soup, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  soup.triangles.push_back({a, b, c});
  soup.triangleMaterial.push_back(0);
}

void addQuad(TriangleSoup& soup, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  addTriangle(soup, a, b, c);
  addTriangle(soup, a, c, d);
}

std::uint32_t addVertex(TriangleSoup& soup, const glm::dvec3& p) {
  soup.positions.push_back(p);
  return static_cast<std::uint32_t>(soup.positions.size() - 1);
}

using Corners = std::array<int, 3>;

struct Icosahedron {
  std::array<glm::dvec3, 12> corners;
  std::array<Corners, 20> faces{{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                 {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                 {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                 {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};

  Icosahedron() {
    const double g = std::numbers::phi;
    corners = {glm::dvec3{-1, g, 0}, {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
               {0, -1, -g},          {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (glm::dvec3& corner : corners) corner = glm::normalize(corner);
  }
};

/// Vertices of one geodesic sphere. A point on an edge of the icosahedron belongs to two faces: it is summed
/// in the order of the corners' numbers and kept once, so that both faces get the same bits.
class SphereVertices {
 public:
  SphereVertices(double radius, int frequency, TriangleSoup& soup)
      : radius_(radius), frequency_(frequency), soup_(soup) {}

  std::uint32_t at(const Corners& face, const Corners& weight) {
    std::array<std::pair<int, int>, 3> terms{
        {{face[0], weight[0]}, {face[1], weight[1]}, {face[2], weight[2]}}};
    std::sort(terms.begin(), terms.end());
    glm::dvec3 sum(0.0);
    bool inside = true;
    for (const auto& [corner, w] : terms) {
      inside = inside && w != 0;
      if (w != 0) sum += static_cast<double>(w) * shape_.corners[static_cast<std::size_t>(corner)];
    }
    const glm::dvec3 p = radius_ * glm::normalize(sum);
    if (inside) return addVertex(soup_, p);
    for (auto& [corner, w] : terms)
      if (w == 0) corner = -1;
    std::sort(terms.begin(), terms.end());
    const auto [entry, isNew] = shared_.try_emplace(terms, 0);
    if (isNew) entry->second = addVertex(soup_, p);
    return entry->second;
  }

  void addFace(const Corners& face) {
    const int f = frequency_;
    std::vector<std::uint32_t> row, above;
    for (int i = 0; i <= f; ++i) {
      row.clear();
      for (int j = 0; j <= i; ++j) row.push_back(at(face, {f - i, i - j, j}));
      for (std::size_t j = 0; j + 1 < row.size(); ++j) {
        addTriangle(soup_, above[j], row[j], row[j + 1]);
        if (j + 1 < above.size()) addTriangle(soup_, above[j], row[j + 1], above[j + 1]);
      }
      above = row;
    }
  }

  const Icosahedron& shape() const { return shape_; }

 private:
  double radius_;
  int frequency_;
  TriangleSoup& soup_;
  Icosahedron shape_;
  std::map<std::array<std::pair<int, int>, 3>, std::uint32_t> shared_;
};

/// The polygon with every edge cut into `pieces`.
Loop subdivided(const Loop& profile, int pieces) {
  Loop fine;
  fine.reserve(profile.size() * static_cast<std::size_t>(pieces));
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const glm::dvec2 a = profile[i], b = profile[(i + 1) % profile.size()];
    for (int k = 0; k < pieces; ++k) fine.push_back(a + (b - a) * (static_cast<double>(k) / pieces));
  }
  return fine;
}

/// Appends one ring of vertices; returns the first.
std::uint32_t addRing(TriangleSoup& soup, const Loop& loop, double share, double z) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  for (const glm::dvec2& p : loop) soup.positions.emplace_back(share * p.x, share * p.y, z);
  return first;
}

void joinRings(TriangleSoup& soup, std::uint32_t lower, std::uint32_t upper, std::uint32_t count) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t j = (i + 1) % count;
    addQuad(soup, lower + i, lower + j, upper + j, upper + i);
  }
}

/// A cap of `rings` rings around its centre, joined to the wall's ring `rim`.
void addCap(TriangleSoup& soup, const Loop& loop, std::uint32_t rim, double z, int rings, bool up) {
  const auto count = static_cast<std::uint32_t>(loop.size());
  std::uint32_t outer = rim;
  for (int r = rings - 1; r >= 1; --r) {
    const std::uint32_t inner = addRing(soup, loop, static_cast<double>(r) / rings, z);
    up ? joinRings(soup, outer, inner, count) : joinRings(soup, inner, outer, count);
    outer = inner;
  }
  const std::uint32_t middle = addVertex(soup, {0.0, 0.0, z});
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t a = outer + i, b = outer + (i + 1) % count;
    up ? addTriangle(soup, a, b, middle) : addTriangle(soup, b, a, middle);
  }
}

/// A grid of n x n quads over the parallelogram from `origin`; normal u x v.
void addGrid(TriangleSoup& soup, const glm::dvec3& origin, const glm::dvec3& u, const glm::dvec3& v, int n) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) addVertex(soup, origin + u * (1.0 * i / n) + v * (1.0 * j / n));
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) addQuad(soup, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
}

}  // namespace

TriangleSoup geodesicSphere(double radius, std::size_t triangles) {
  const int frequency =
      std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(triangles) / 20.0))));
  TriangleSoup soup;
  SphereVertices vertices(radius, frequency, soup);
  for (const Corners& face : vertices.shape().faces) vertices.addFace(face);
  return soup;
}

double deepestFacet(const TriangleSoup& sphere, double radius) {
  double nearest = radius;
  for (const auto& t : sphere.triangles) {
    const glm::dvec3 &a = sphere.positions[t[0]], &b = sphere.positions[t[1]], &c = sphere.positions[t[2]];
    nearest = std::min(nearest, glm::dot(a, glm::normalize(glm::cross(b - a, c - a))));
  }
  return radius - nearest;
}

Loop gearProfile(const GearShape& shape) {
  Loop loop;
  const double pitch = 2.0 * std::numbers::pi / shape.teeth;
  // Half angles of a tooth: 0.32 of the pitch at the root, 0.14 at the tip, bulging outwards between.
  const auto half = [&](double up) { return pitch * (0.32 - 0.10 * up - 0.08 * up * up); };
  const auto at = [&](double radius, double angle) {
    loop.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  };
  for (int tooth = 0; tooth < shape.teeth; ++tooth) {
    const double middle = tooth * pitch;
    for (int side = -1; side <= 1; side += 2) {
      for (int i = 0; i <= shape.flankSteps; ++i) {
        const double share = static_cast<double>(i) / shape.flankSteps, up = side < 0 ? share : 1.0 - share;
        at(shape.rootRadius + (shape.tipRadius - shape.rootRadius) * up, middle + side * half(up));
      }
    }
  }
  return loop;
}

TriangleSoup extrudeStar(const Loop& profile, double thickness, std::size_t triangles) {
  // An edge cut into m pieces, 5 m layers of wall and 1.25 m rings of cap make 15 m^2 triangles an edge, with
  // four as the fewest.
  const double perEdge = static_cast<double>(triangles) / static_cast<double>(profile.size());
  const double pieces = std::sqrt(perEdge / 15.0);
  const int m = std::max(1, static_cast<int>(std::lround(pieces)));
  const int rings = std::max(1, static_cast<int>(std::lround(1.25 * pieces)));
  const int layers = std::max(1, static_cast<int>(std::lround(perEdge / (2.0 * m) - 2.0 * rings + 1.0)));
  const Loop loop = subdivided(profile, m);
  const auto count = static_cast<std::uint32_t>(loop.size());
  TriangleSoup soup;
  std::vector<std::uint32_t> walls;
  for (int i = 0; i <= layers; ++i)
    walls.push_back(addRing(soup, loop, 1.0, thickness * (static_cast<double>(i) / layers - 0.5)));
  for (std::size_t i = 0; i + 1 < walls.size(); ++i) joinRings(soup, walls[i], walls[i + 1], count);
  addCap(soup, loop, walls.front(), -0.5 * thickness, rings, false);
  addCap(soup, loop, walls.back(), 0.5 * thickness, rings, true);
  return soup;
}

TriangleSoup flatSheet(double size, int n) {
  TriangleSoup soup;
  addGrid(soup, {-0.5 * size, -0.5 * size, 0.0}, {size, 0.0, 0.0}, {0.0, size, 0.0}, n);
  return soup;
}

TriangleSoup vGroove(double size, double halfAngle, int n) {
  TriangleSoup soup;
  const glm::dvec3 apex(0.0, -size, 0.0), along(0.0, 2.0 * size, 0.0);
  const double x = size * std::sin(halfAngle), z = size * std::cos(halfAngle);
  addGrid(soup, apex, {x, 0.0, z}, along, n);
  addGrid(soup, apex, along, {-x, 0.0, z}, n);
  return soup;
}

TriangleSoup plainBox(const glm::dvec3& size) {
  TriangleSoup soup;
  for (int i = 0; i < 8; ++i)
    addVertex(soup, {(i & 1) != 0 ? 0.5 * size.x : -0.5 * size.x, (i & 2) != 0 ? 0.5 * size.y : -0.5 * size.y,
                     (i & 4) != 0 ? 0.5 * size.z : -0.5 * size.z});
  for (const auto& q : {std::array<std::uint32_t, 4>{0, 4, 6, 2},
                        {1, 3, 7, 5},
                        {0, 1, 5, 4},
                        {2, 6, 7, 3},
                        {0, 2, 3, 1},
                        {4, 5, 7, 6}})
    addQuad(soup, q[0], q[1], q[2], q[3]);
  return soup;
}

}  // namespace tandem::generate
