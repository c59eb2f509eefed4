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

}  // namespace

std::unique_ptr<SurfaceScene> makeSurfaceScene(const assets::Scene& scene,
                                               const std::vector<Collider>& colliders) {
  if (scene.surfaces.empty()) return nullptr;
  auto out = std::make_unique<SurfaceScene>();
  out->parts.resize(colliders.size());
  std::map<const TriangleBvh*, PartSurface> known;  // instances share the data of a mesh
  bool any = false;
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    const TriangleBvh* tree = colliders[i].tree;
    if (tree == nullptr) continue;
    const auto [it, isNew] = known.try_emplace(tree);
    PartSurface& part = it->second;
    if (isNew) {
      const std::vector<bool> used = materialsOf(scene, tree->mesh());
      std::vector<double> creases(scene.materials.size(), 0.0);
      bool shades = false;
      for (std::size_t m = 0; m < used.size(); ++m) {
        const assets::Material& material = scene.materials[m];
        if (!used[m] || material.surface >= scene.surfaces.size()) continue;
        const assets::Surface& surface = scene.surfaces[material.surface];
        part.any = true;
        creases[m] = surface.creaseAngle;
        shades = shades || surface.creaseAngle > 0.0;
        addReach(material, surface, part);
      }
      if (shades) {
        out->shaded.push_back(std::make_unique<ShadedMesh>(shadeMesh(tree->mesh(), creases)));
        part.shaded = out->shaded.back().get();
        part.reach += part.shaded->relief;
      }
    }
    out->parts[i] = part;
    any = any || part.any;
    out->reach = std::max(out->reach, part.reach);
    out->forceReach = std::max(out->forceReach, part.forceReach);
  }
  return any ? std::move(out) : nullptr;
}

}  // namespace tandem::haptics
