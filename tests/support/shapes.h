#pragma once

// Meshes and scenes made in code, for tests and benches that need geometry with an exact answer.

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "assets/base/constants.h"
#include "assets/mesh/mesh_analysis.h"
#include "assets/scene/scene.h"

namespace tandem::test {

/// Triangles under construction.
struct ShapeBuilder {
  assets::TriangleSoup soup;

  std::uint32_t vertex(double x, double y, double z) {
    soup.positions.emplace_back(x, y, z);
    return static_cast<std::uint32_t>(soup.positions.size() - 1);
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    soup.triangles.push_back({a, b, c});
    soup.triangleMaterial.push_back(0);
  }
  /// Corners counter-clockwise seen from outside.
  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }
  assets::Mesh mesh() const { return assets::analyseMesh(soup, 0.5).mesh; }
};

/// A box around the origin.
inline assets::Mesh boxMesh(const glm::dvec3& size) {
  ShapeBuilder b;
  for (int i = 0; i < 8; ++i) {
    b.vertex((i & 1) != 0 ? 0.5 * size.x : -0.5 * size.x, (i & 2) != 0 ? 0.5 * size.y : -0.5 * size.y,
             (i & 4) != 0 ? 0.5 * size.z : -0.5 * size.z);
  }
  b.quad(0, 4, 6, 2);
  b.quad(1, 3, 7, 5);
  b.quad(0, 1, 5, 4);
  b.quad(2, 6, 7, 3);
  b.quad(0, 2, 3, 1);
  b.quad(4, 5, 7, 6);
  return b.mesh();
}

/// A square sheet in the plane z = 0, normal +z, of n x n quads.
inline assets::Mesh sheetMesh(double size, int n) {
  ShapeBuilder b;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) b.vertex(size * (1.0 * i / n - 0.5), size * (1.0 * j / n - 0.5), 0.0);
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const auto at = [n](int x, int y) { return static_cast<std::uint32_t>(y * (n + 1) + x); };
      b.quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return b.mesh();
}

/// A sphere by latitudes and longitudes; vertices lie on the surface. 4 n (n - 1) triangles.
inline assets::TriangleSoup sphereSoup(double radius, int n) {
  ShapeBuilder b;
  const int around = 2 * n;
  const std::uint32_t top = b.vertex(0.0, 0.0, radius), bottom = b.vertex(0.0, 0.0, -radius);
  for (int j = 1; j < n; ++j) {
    const double polar = kPi * j / n;
    for (int i = 0; i < around; ++i) {
      const double angle = 2.0 * kPi * i / around;
      b.vertex(radius * std::sin(polar) * std::cos(angle), radius * std::sin(polar) * std::sin(angle),
               radius * std::cos(polar));
    }
  }
  const auto at = [around](int j, int i) {
    return static_cast<std::uint32_t>(2 + (j - 1) * around + i % around);
  };
  for (int i = 0; i < around; ++i) {
    b.triangle(top, at(1, i), at(1, i + 1));
    b.triangle(bottom, at(n - 1, i + 1), at(n - 1, i));
    for (int j = 1; j + 1 < n; ++j) b.quad(at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1));
  }
  return b.soup;
}

inline assets::Mesh sphereMesh(double radius, int n) {
  return assets::analyseMesh(sphereSoup(radius, n), 0.5).mesh;
}

/// A groove along y: two walls from the apex line at the origin upwards, each at `halfAngle` from +z.
inline assets::Mesh grooveMesh(double size, double halfAngle) {
  ShapeBuilder b;
  const double x = size * std::sin(halfAngle), z = size * std::cos(halfAngle);
  const std::uint32_t a0 = b.vertex(0.0, -size, 0.0), a1 = b.vertex(0.0, size, 0.0);
  const std::uint32_t r0 = b.vertex(x, -size, z), r1 = b.vertex(x, size, z);
  const std::uint32_t l0 = b.vertex(-x, -size, z), l1 = b.vertex(-x, size, z);
  b.quad(a0, r0, r1, a1);
  b.quad(a0, a1, l1, l0);
  return b.mesh();
}

/// The inner corner of three faces in x = 0, y = 0, z = 0; the free space is the positive octant.
inline assets::Mesh cornerMesh(double size) {
  ShapeBuilder b;
  const std::uint32_t o = b.vertex(0, 0, 0), x = b.vertex(size, 0, 0), y = b.vertex(0, size, 0);
  const std::uint32_t z = b.vertex(0, 0, size), xy = b.vertex(size, size, 0);
  const std::uint32_t yz = b.vertex(0, size, size), zx = b.vertex(size, 0, size);
  b.quad(o, x, xy, y);
  b.quad(o, y, yz, z);
  b.quad(o, z, zx, x);
  return b.mesh();
}

/// A scene of one material, to which parts are added.
struct SceneBuilder {
  assets::Scene scene;

  SceneBuilder() { scene.materials.emplace_back(); }

  std::uint32_t addMesh(assets::Mesh mesh) {
    scene.meshes.push_back(std::move(mesh));
    return static_cast<std::uint32_t>(scene.meshes.size() - 1);
  }
  /// A part; movable if it has a mass. Its inertia is that of a box of the mesh's bounds.
  PartId addPart(std::uint32_t mesh, const Pose& pose = {}, double mass = 0.0) {
    assets::Part part;
    part.name = "part" + std::to_string(scene.parts.size());
    part.mesh = mesh;
    part.worldFromPart = pose;
    part.movable = mass > 0.0;
    if (mass > 0.0) {
      const assets::Bounds& box = scene.meshes[mesh].bounds;
      const glm::dvec3 s = box.max - box.min;
      part.massProperties.mass = mass;
      part.massProperties.centreOfMass = 0.5 * (box.min + box.max);
      part.massProperties.inertia = glm::dmat3(0.0);
      part.massProperties.inertia[0][0] = mass / 12.0 * (s.y * s.y + s.z * s.z);
      part.massProperties.inertia[1][1] = mass / 12.0 * (s.x * s.x + s.z * s.z);
      part.massProperties.inertia[2][2] = mass / 12.0 * (s.x * s.x + s.y * s.y);
    }
    scene.parts.push_back(std::move(part));
    return static_cast<PartId>(scene.parts.size() - 1);
  }
  PartId addPart(assets::Mesh mesh, const Pose& pose = {}, double mass = 0.0) {
    return addPart(addMesh(std::move(mesh)), pose, mass);
  }
};

}  // namespace tandem::test
