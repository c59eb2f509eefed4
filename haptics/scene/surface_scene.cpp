#include "haptics/scene/surface_scene.h"

#include <algorithm>
#include <map>

namespace tandem::haptics {
namespace {

/// Which materials a mesh uses.
std::vector<bool> materialsOf(const assets::Scene& scene, const assets::Mesh& mesh) {
  std::vector<bool> used(scene.materials.size(), false);
  for (const std::uint16_t material : mesh.triangleMaterial)
    if (material < used.size()) used[material] = true;
  return used;
}

void addReach(const assets::Material& material, const assets::Surface& surface, PartSurface& part) {
  const assets::SurfaceTexture& texture = surface.texture;
  double relief = texture.amplitude;
  if (material.stiffness > 0.0) {
    relief += texture.amplitudeForce / material.stiffness;
  } else {
    part.forceReach = std::max(part.forceReach, texture.amplitudeForce);
  }
  const bool pulls = surface.magneticForce > 0.0;
  part.reach = std::max({part.reach, relief, pulls ? surface.magneticDistance : 0.0});
}

bool isMagnet(const assets::Surface& surface) {
  return surface.magneticForce > 0.0 && surface.magneticDistance > 0.0;
}

/// The magnets of a mesh; null if it has none.
const std::vector<Magnet>* magnetsOf(const assets::Scene& scene, const TriangleBvh& tree, SurfaceScene& out) {
  const assets::Mesh& mesh = tree.mesh();
  std::map<std::uint32_t, std::vector<std::uint32_t>> faces;  // of each magnetic surface
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint16_t material =
        t < mesh.triangleMaterial.size() ? mesh.triangleMaterial[t] : std::uint16_t{0};
    if (material >= scene.materials.size()) continue;
    const std::uint32_t surface = scene.materials[material].surface;
    if (surface < scene.surfaces.size() && isMagnet(scene.surfaces[surface])) faces[surface].push_back(t);
  }
  if (faces.empty()) return nullptr;
  std::vector<Magnet> magnets;
  for (const auto& [surface, triangles] : faces) {
    magnets.push_back({surface, &tree});
    out.magneticReach = std::max(out.magneticReach, scene.surfaces[surface].magneticDistance);
    if (triangles.size() == mesh.triangles.size()) continue;
    assets::Mesh part;
    part.positions = mesh.positions;
    for (const std::uint32_t t : triangles) part.triangles.push_back(mesh.triangles[t]);
    out.faces.push_back(std::make_unique<SomeFaces>(std::move(part)));
    magnets.back().tree = &out.faces.back()->tree;
  }
  out.magnets.push_back(std::make_unique<const std::vector<Magnet>>(std::move(magnets)));
  return out.magnets.back().get();
}

/// What a mesh adds to a part. A material without a surface is as smooth as the file's normals say.
PartSurface surfaceOf(const assets::Scene& scene, const assets::Mesh& mesh, bool normals, SurfaceScene& out) {
  PartSurface part;
  if (scene.surfaces.empty() && !normals) return part;
  const std::vector<bool> used = materialsOf(scene, mesh);
  std::vector<double> creases(scene.materials.size(), 0.0);
  bool shades = false;
  for (std::size_t m = 0; m < used.size(); ++m) {
    if (!used[m]) continue;
    const assets::Material& material = scene.materials[m];
    double crease = 0.0;
    if (material.surface < scene.surfaces.size()) {
      const assets::Surface& surface = scene.surfaces[material.surface];
      part.any = true;
      crease = surface.creaseAngle;
      addReach(material, surface, part);
    }
    // A surface that says how smooth it is has no normals of the file.
    creases[m] = crease > 0.0 || !normals ? crease : kFileNormals;
    shades = shades || creases[m] != 0.0;
  }
  if (!shades) return part;
  part.any = true;
  out.shaded.push_back(std::make_unique<ShadedMesh>(shadeMesh(mesh, creases)));
  part.shaded = out.shaded.back().get();
  part.reach += part.shaded->relief;
  return part;
}

}  // namespace

std::unique_ptr<SurfaceScene> makeSurfaceScene(const assets::Scene& scene,
                                               const std::vector<Collider>& colliders,
                                               const std::set<const TriangleBvh*>& deformed) {
  const auto hasNormals = [&](const TriangleBvh* tree) {
    return tree != nullptr && !tree->mesh().triangleNormal.empty() && deformed.count(tree) == 0;
  };
  const bool normals = std::any_of(colliders.begin(), colliders.end(),
                                   [&](const Collider& collider) { return hasNormals(collider.tree); });
  if (scene.surfaces.empty() && !normals) return nullptr;
  auto out = std::make_unique<SurfaceScene>();
  out->parts.resize(colliders.size());
  std::map<const TriangleBvh*, PartSurface> known;  // instances share the data of a mesh
  bool any = false;
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    const TriangleBvh* tree = colliders[i].tree;
    if (tree == nullptr) continue;
    const auto [it, isNew] = known.try_emplace(tree);
    if (isNew) {
      it->second = surfaceOf(scene, tree->mesh(), hasNormals(tree), *out);
      it->second.magnets = magnetsOf(scene, *tree, *out);
    }
    const PartSurface& part = it->second;
    out->parts[i] = part;
    any = any || part.any;
    out->reach = std::max(out->reach, part.reach);
    out->forceReach = std::max(out->forceReach, part.forceReach);
  }
  return any ? std::move(out) : nullptr;
}

}  // namespace tandem::haptics
