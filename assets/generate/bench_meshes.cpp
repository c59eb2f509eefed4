#include "assets/generate/bench_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/constants.h"
#include "assets/mesh/mesh_analysis.h"

namespace tandem::generate {
namespace {

constexpr double kPressureAngle = kPi / 9.0;
constexpr double kModule = 2.0 * kGearPitchRadius / kGearTeeth;
constexpr double kTipRadius = kGearPitchRadius + kModule;
constexpr double kRootRadius = kGearPitchRadius - 1.25 * kModule;
constexpr double kRootHalfAngle = 9.5 * kPi / 180.0;  // of a tooth at its root: wider than at the base circle
constexpr int kInvolutePieces = 6;
constexpr int kFlankPoints = kInvolutePieces + 2;  // root, base circle, then up to the tip

assets::Mesh finish(assets::TriangleSoup soup, Topology topology) {
  const bool cheap = soup.triangles.size() <= kAnalysedTriangles;
  soup.triangleMaterial.assign(soup.triangles.size(), 0);
  if (topology == Topology::always || (topology == Topology::whenCheap && cheap)) {
    return assets::analyseMesh(std::move(soup), 0.5).mesh;
  }
  assets::Mesh mesh;
  mesh.positions = std::move(soup.positions);
  mesh.triangles = std::move(soup.triangles);
  mesh.triangleMaterial = std::move(soup.triangleMaterial);
  for (const glm::dvec3& p : mesh.positions) {
    mesh.bounds.include(p);
  }
  return mesh;
}

double involute(double angle) { return std::tan(angle) - angle; }

/// Half the angle of a tooth at radius r.
double toothHalfAngle(double r) {
  const double base = kGearPitchRadius * std::cos(kPressureAngle);
  if (r < base) return kRootHalfAngle;
  return kPi / (2 * kGearTeeth) + involute(kPressureAngle) - involute(std::acos(std::min(1.0, base / r)));
}

glm::dvec2 polar(double r, double angle) { return {r * std::cos(angle), r * std::sin(angle)}; }

/// A flank of a tooth from root to tip; side -1 is the one met first, counter-clockwise.
std::array<glm::dvec2, kFlankPoints> flank(int tooth, double side) {
  const double middle = 2.0 * kPi * tooth / kGearTeeth;
  const double base = kGearPitchRadius * std::cos(kPressureAngle);
  std::array<glm::dvec2, kFlankPoints> points;
  points[0] = polar(kRootRadius, middle + side * kRootHalfAngle);
  for (int i = 0; i <= kInvolutePieces; ++i) {
    const double r = base + (kTipRadius - base) * i / kInvolutePieces;
    points[static_cast<std::size_t>(i + 1)] = polar(r, middle + side * toothHalfAngle(r));
  }
  return points;
}

int pieces(double length, double edge) { return std::max(1, static_cast<int>(std::ceil(length / edge))); }

/// How often each kind of line of the gear is cut for edges of at most `edge` m.
struct GearCuts {
  explicit GearCuts(double edge) {
    const auto up = flank(0, -1.0), down = flank(0, 1.0), next = flank(1, -1.0);
    for (std::size_t i = 0; i + 1 < up.size(); ++i) {
      flankPieces[i] = pieces(glm::length(up[i + 1] - up[i]), edge);
      rows += flankPieces[i];
    }
    columns = pieces(glm::length(down[0] - up[0]), edge);
    root = pieces(glm::length(next[0] - down[0]), edge);
    layers = pieces(kGearHeight, edge);
    rings = pieces(kRootRadius, edge);
  }
  int around() const { return kGearTeeth * (columns + root); }              // of the core
  int outline() const { return kGearTeeth * (2 * rows + columns + root); }  // of the gear
  std::int64_t triangles() const {
    const std::int64_t cap =
        std::int64_t{around()} * (2 * rings - 1) + std::int64_t{kGearTeeth} * rows * columns * 2;
    return 2 * cap + std::int64_t{outline()} * layers * 2;
  }

  std::array<int, kFlankPoints - 1> flankPieces{};
  int rows = 0, columns = 0, root = 0, layers = 0, rings = 0;
};

/// The flank with its cuts: rows + 1 points.
std::vector<glm::dvec2> cutFlank(int tooth, double side, const GearCuts& cuts) {
  const auto corners = flank(tooth, side);
  std::vector<glm::dvec2> points;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    for (int k = 0; k < cuts.flankPieces[i]; ++k) {
      points.push_back(glm::mix(corners[i], corners[i + 1], static_cast<double>(k) / cuts.flankPieces[i]));
    }
  }
  points.push_back(corners.back());
  return points;
}

using Index = std::uint32_t;

/// The flat outline area cut into triangles, counter-clockwise, and its boundary in order.
struct Cap {
  std::vector<glm::dvec2> points;
  std::vector<std::array<Index, 3>> triangles;
  std::vector<Index> boundary;

  Index add(const glm::dvec2& p) {
    points.push_back(p);
    return static_cast<Index>(points.size() - 1);
  }
  void quad(Index a, Index b, Index c, Index d) {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  }
};

/// A tooth in rows from one flank to the other; its lowest row, the chord between its roots, is shared with
/// the core.
void addTooth(Cap& cap, int tooth, const GearCuts& cuts, std::vector<Index>& core) {
  const std::vector<glm::dvec2> first = cutFlank(tooth, -1.0, cuts), second = cutFlank(tooth, 1.0, cuts);
  std::vector<std::vector<Index>> grid(first.size());
  for (std::size_t r = 0; r < first.size(); ++r) {
    for (int c = 0; c <= cuts.columns; ++c) {
      const bool last = c == cuts.columns;
      grid[r].push_back(
          cap.add(last ? second[r] : glm::mix(first[r], second[r], static_cast<double>(c) / cuts.columns)));
    }
  }
  const auto columns = static_cast<std::size_t>(cuts.columns);
  for (std::size_t r = 0; r + 1 < grid.size(); ++r) {
    for (std::size_t c = 0; c < columns; ++c)
      cap.quad(grid[r][c], grid[r + 1][c], grid[r + 1][c + 1], grid[r][c + 1]);
  }
  for (const Index i : grid.front()) core.push_back(i);
  for (std::size_t r = 0; r < grid.size(); ++r) cap.boundary.push_back(grid[r].front());
  for (std::size_t c = 1; c < columns; ++c) cap.boundary.push_back(grid.back()[c]);
  for (std::size_t r = grid.size(); r-- > 0;) cap.boundary.push_back(grid[r].back());
}

/// The flat root between a tooth and the next.
void addRoot(Cap& cap, int tooth, const GearCuts& cuts, std::vector<Index>& core) {
  const glm::dvec2 from = flank(tooth, 1.0)[0], to = flank((tooth + 1) % kGearTeeth, -1.0)[0];
  for (int k = 1; k < cuts.root; ++k) {
    const Index i = cap.add(glm::mix(from, to, static_cast<double>(k) / cuts.root));
    core.push_back(i);
    cap.boundary.push_back(i);
  }
}

/// The core inside the roots: rings of ever smaller copies of its outline, and a fan in the middle.
void fillCore(Cap& cap, const GearCuts& cuts, std::vector<Index> outer) {
  const std::size_t around = outer.size();
  for (int ring = cuts.rings - 1; ring > 0; --ring) {
    std::vector<Index> inner;
    for (const Index i : outer) inner.push_back(cap.add(cap.points[i] * (ring / (ring + 1.0))));
    for (std::size_t k = 0; k < around; ++k) {
      cap.quad(outer[k], outer[(k + 1) % around], inner[(k + 1) % around], inner[k]);
    }
    outer = std::move(inner);
  }
  const Index middle = cap.add({0.0, 0.0});
  for (std::size_t k = 0; k < around; ++k)
    cap.triangles.push_back({outer[k], outer[(k + 1) % around], middle});
}

Cap gearCap(const GearCuts& cuts) {
  Cap cap;
  std::vector<Index> core;
  for (int tooth = 0; tooth < kGearTeeth; ++tooth) {
    addTooth(cap, tooth, cuts, core);
    addRoot(cap, tooth, cuts, core);
  }
  fillCore(cap, cuts, std::move(core));
  return cap;
}

assets::TriangleSoup extrude(const Cap& cap, const GearCuts& cuts) {
  assets::TriangleSoup soup;
  const auto count = static_cast<Index>(cap.points.size());
  for (const double z : {0.0, kGearHeight}) {
    for (const glm::dvec2& p : cap.points) soup.positions.emplace_back(p.x, p.y, z);
  }
  for (const auto& [a, b, c] : cap.triangles) {
    soup.triangles.push_back({a, c, b});
    soup.triangles.push_back({count + a, count + b, count + c});
  }
  std::vector<Index> lower = cap.boundary;
  const std::size_t around = lower.size();
  for (int layer = 1; layer <= cuts.layers; ++layer) {
    std::vector<Index> upper;
    for (const Index i : cap.boundary) {
      upper.push_back(layer == cuts.layers ? count + i : static_cast<Index>(soup.positions.size()));
      if (layer == cuts.layers) continue;
      const glm::dvec2& p = cap.points[i];
      soup.positions.emplace_back(p.x, p.y, kGearHeight * layer / cuts.layers);
    }
    for (std::size_t k = 0; k < around; ++k) {
      const std::size_t next = (k + 1) % around;
      soup.triangles.push_back({lower[k], lower[next], upper[next]});
      soup.triangles.push_back({lower[k], upper[next], upper[k]});
    }
    lower = std::move(upper);
  }
  return soup;
}

/// A box with its top face in z = 0.
assets::Mesh plateMesh(double edge, double thickness) {
  assets::TriangleSoup soup;
  for (int i = 0; i < 8; ++i) {
    soup.positions.emplace_back((i & 1) != 0 ? 0.5 * edge : -0.5 * edge,
                                (i & 2) != 0 ? 0.5 * edge : -0.5 * edge, (i & 4) != 0 ? 0.0 : -thickness);
  }
  constexpr Index kQuads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                  {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& q : kQuads) {
    soup.triangles.push_back({q[0], q[1], q[2]});
    soup.triangles.push_back({q[0], q[2], q[3]});
  }
  return finish(std::move(soup), Topology::always);
}

/// A grid of n x n quads over the parallelogram from `origin`; normal u x v.
void addGrid(assets::TriangleSoup& soup, const glm::dvec3& origin, const glm::dvec3& u, const glm::dvec3& v,
             int n) {
  const auto first = static_cast<Index>(soup.positions.size());
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) soup.positions.push_back(origin + u * (1.0 * i / n) + v * (1.0 * j / n));
  const auto at = [&](int i, int j) { return first + static_cast<Index>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
}

assets::Scene emptyScene() {
  assets::Scene scene;
  scene.materials.emplace_back();
  return scene;
}

void addPart(assets::Scene& scene, const glm::dvec3& position) {
  assets::Part part;
  part.name = "part" + std::to_string(scene.parts.size());
  part.mesh = 0;
  part.worldFromPart.position = position;
  const assets::Bounds& box = scene.meshes[0].bounds;
  scene.bounds.include({position + box.min, position + box.max});
  scene.parts.push_back(std::move(part));
}

assets::TriangleSoup sphereSoup(double radius, int triangles) {
  const int f = std::max(1, static_cast<int>(std::ceil(std::sqrt(triangles / 8.0))));
  assets::TriangleSoup soup;
  // Ring k from the north pole has 4 k vertices, as on an octahedron cut f times; rings are equally spaced.
  const auto ringSize = [f](int k) { return 4 * std::min(k, 2 * f - k); };
  std::vector<Index> first;
  for (int k = 0; k <= 2 * f; ++k) {
    first.push_back(static_cast<Index>(soup.positions.size()));
    const double polarAngle = kPi * k / (2.0 * f);
    for (int i = 0; i < std::max(1, ringSize(k)); ++i) {
      const double angle = 2.0 * kPi * i / std::max(1, ringSize(k));
      soup.positions.push_back(radius * glm::dvec3(std::sin(polarAngle) * std::cos(angle),
                                                   std::sin(polarAngle) * std::sin(angle),
                                                   std::cos(polarAngle)));
    }
  }
  const auto at = [&](int k, int i) {
    return first[static_cast<std::size_t>(k)] + static_cast<Index>(i % std::max(1, ringSize(k)));
  };
  for (int k = 0; k < 2 * f; ++k) {
    const bool north = k < f;
    const int small = north ? k : 2 * f - k - 1;  // steps of a quarter of the smaller ring
    const int inner = north ? k : k + 1, outer = north ? k + 1 : k;
    for (int quarter = 0; quarter < 4; ++quarter) {
      for (int i = 0; i <= small; ++i) {
        const int o = quarter * (small + 1) + i, n = quarter * small + i;
        std::array<Index, 3> t{at(inner, n), at(outer, o), at(outer, o + 1)};
        if (!north) std::swap(t[1], t[2]);
        soup.triangles.push_back(t);
        if (i == small) continue;
        t = {at(inner, n), at(outer, o + 1), at(inner, n + 1)};
        if (!north) std::swap(t[1], t[2]);
        soup.triangles.push_back(t);
      }
    }
  }
  return soup;
}

}  // namespace

assets::Mesh sphereMesh(double radius, int triangles, Topology topology) {
  return finish(sphereSoup(radius, triangles), topology);
}

double scanWave(double radius, const glm::dvec3& n) {
  return 0.04 * radius * (std::sin(5.0 * n.x + 1.0) * std::sin(7.0 * n.y) + 0.5 * std::sin(11.0 * n.z + n.x));
}

assets::Mesh scanMesh(double radius, int triangles, double noise, unsigned seed, Topology topology) {
  assets::TriangleSoup soup = sphereSoup(radius, triangles);
  const double triangle = 4.0 * kPi * radius * radius / static_cast<double>(soup.triangles.size());
  const double edge = std::sqrt(triangle * 4.0 / std::sqrt(3.0));  // of equilateral triangles
  std::mt19937 random(seed);
  // The standard's distributions differ from library to library; the engine does not.
  const auto draw = [&] { return 2.0 * (static_cast<double>(random()) / 4294967295.0) - 1.0; };
  for (glm::dvec3& p : soup.positions) {
    const glm::dvec3 n = p / radius;
    const glm::dvec3 displaced{draw(), draw(), draw()};
    p += n * scanWave(radius, n) + displaced * (noise * edge);
  }
  return finish(std::move(soup), topology);
}

double deepestFacet(const assets::Mesh& sphere, double radius) {
  double nearest = radius;
  for (const auto& t : sphere.triangles) {
    const glm::dvec3 &a = sphere.positions[t[0]], &b = sphere.positions[t[1]], &c = sphere.positions[t[2]];
    nearest = std::min(nearest, glm::dot(a, glm::normalize(glm::cross(b - a, c - a))));
  }
  return radius - nearest;
}

assets::Mesh flatSheet(double size, int n) {
  assets::TriangleSoup soup;
  addGrid(soup, {-0.5 * size, -0.5 * size, 0.0}, {size, 0.0, 0.0}, {0.0, size, 0.0}, n);
  return finish(std::move(soup), Topology::always);
}

assets::Mesh vGroove(double size, double halfAngle, int n) {
  assets::TriangleSoup soup;
  const glm::dvec3 apex(0.0, -size, 0.0), along(0.0, 2.0 * size, 0.0);
  const double x = size * std::sin(halfAngle), z = size * std::cos(halfAngle);
  addGrid(soup, apex, {x, 0.0, z}, along, n);
  addGrid(soup, apex, along, {-x, 0.0, z}, n);
  return finish(std::move(soup), Topology::always);
}

std::vector<glm::dvec2> gearProfile() {
  std::vector<glm::dvec2> profile;
  for (int tooth = 0; tooth < kGearTeeth; ++tooth) {
    const auto up = flank(tooth, -1.0), down = flank(tooth, 1.0);
    profile.insert(profile.end(), up.begin(), up.end());
    profile.insert(profile.end(), down.rbegin(), down.rend());
  }
  return profile;
}

assets::Mesh gearMesh(int triangles, Topology topology) {
  double fine = 1e-6, coarse = 0.1;
  for (int i = 0; i < 60; ++i) {
    const double edge = 0.5 * (fine + coarse);
    (GearCuts(edge).triangles() >= triangles ? fine : coarse) = edge;
  }
  const GearCuts cuts(fine);
  return finish(extrude(gearCap(cuts), cuts), topology);
}

assets::Scene sceneOf(assets::Mesh mesh) {
  assets::Scene scene = emptyScene();
  scene.meshes.push_back(std::move(mesh));
  addPart(scene, {0.0, 0.0, 0.0});
  return scene;
}

assets::Scene plateGrid(int columns, double edge, double thickness) {
  assets::Scene scene = emptyScene();
  scene.meshes.push_back(plateMesh(edge, thickness));
  for (int i = 0; i < columns * columns; ++i) {
    addPart(scene,
            {edge * (i % columns - 0.5 * (columns - 1)), edge * (i / columns - 0.5 * (columns - 1)), 0.0});
  }
  return scene;
}

assets::Scene smallParts(int count) {
  constexpr double kPitch = 0.005, kRadius = 0.002;  // m
  assets::Scene scene = emptyScene();
  scene.meshes.push_back(sphereMesh(kRadius, 200, Topology::always));
  const assets::MassProperties mass = assets::massProperties(scene.meshes[0], 7800.0);
  const int columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(count))));
  for (int i = 0; i < count; ++i) {
    addPart(scene, {kPitch * (i % columns - 0.5 * (columns - 1)),
                    kPitch * (i / columns - 0.5 * (columns - 1)), 0.0});
    scene.parts.back().movable = true;
    scene.parts.back().massProperties = mass;
  }
  return scene;
}

}  // namespace tandem::generate
