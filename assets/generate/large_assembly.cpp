#include "assets/generate/large_assembly.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "assets/base/parallel.h"
#include "assets/generate/bench_meshes.h"
#include "assets/mesh/mesh_analysis.h"

namespace tandem::generate {
namespace {

constexpr double kPartPitch = 0.05, kCastingRadius = 0.018;  // m
constexpr double kScanNoise = 0.02;                          // of a mean edge
constexpr double kDensityOfSteel = 7800.0;                   // kg/m^3

assets::Mesh castingMesh(int triangles, unsigned seed) {
  assets::Mesh mesh = scanMesh(kCastingRadius, triangles, kScanNoise, seed, Topology::always);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (mesh.positions[mesh.triangles[t][0]].z > 0.5 * kCastingRadius) mesh.triangleMaterial[t] = 1;
  return mesh;
}

/// No two gears are equal: an assembly shares its equal meshes.
assets::Mesh numberedGear(int triangles, int number) {
  assets::Mesh mesh = gearMesh(triangles, Topology::always);
  const double share = 1.0 - 1e-3 * number;
  for (glm::dvec3& p : mesh.positions) p *= share;
  mesh.bounds.min *= share;
  mesh.bounds.max *= share;
  mesh.volume *= share * share * share;
  return mesh;
}

}  // namespace

assets::Scene largeAssembly(int parts, int triangles) {
  assets::Scene scene;
  scene.name = "large assembly";
  scene.materials.resize(2);
  scene.materials[1].baseColour = {0.55f, 0.3f, 0.12f, 1.0f};
  scene.meshes.resize(static_cast<std::size_t>(parts));
  scene.parts.resize(scene.meshes.size());
  const int columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(parts))));
  parallelFor(scene.meshes.size(), [&](std::size_t i) {
    const int number = static_cast<int>(i);
    scene.meshes[i] = number % 2 == 0 ? castingMesh(triangles, static_cast<unsigned>(number))
                                      : numberedGear(triangles, number);
    assets::Part& part = scene.parts[i];
    part.name = "part" + std::to_string(number);
    part.mesh = static_cast<std::uint32_t>(i);
    part.movable = true;
    part.massProperties = assets::massProperties(scene.meshes[i], kDensityOfSteel);
    part.worldFromPart.position = {kPartPitch * (number % columns - 0.5 * (columns - 1)),
                                   kPartPitch * (number / columns - 0.5 * (columns - 1)), 0.0};
  });
  for (const assets::Part& part : scene.parts) {
    const assets::Bounds& box = scene.meshes[part.mesh].bounds;
    const glm::dvec3& at = part.worldFromPart.position;
    scene.bounds.include({at + box.min, at + box.max});
  }
  return scene;
}

}  // namespace tandem::generate
