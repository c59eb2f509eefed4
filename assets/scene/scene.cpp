#include "assets/scene/scene.h"

#include <utility>

namespace tandem::assets {

std::size_t triangleCount(const Scene& scene, const Part& part) {
  return part.mesh == kNone ? 0 : scene.meshes[part.mesh].triangles.size();
}

std::size_t triangleCount(const Scene& scene) {
  std::size_t count = 0;
  for (const Part& part : scene.parts) count += triangleCount(scene, part);
  return count;
}

void dropGeometry(Scene& scene) {
  for (Mesh& mesh : scene.meshes) {
    Mesh whole;
    whole.shellCount = mesh.shellCount;
    whole.closed = mesh.closed;
    whole.volume = mesh.volume;
    whole.bounds = mesh.bounds;
    mesh = std::move(whole);
  }
}

void dropShells(Scene& scene) {
  for (Mesh& mesh : scene.meshes) mesh.triangleShell = {};
}

PartId findPart(const Scene& scene, std::string_view name) {
  for (std::size_t i = 0; i < scene.parts.size(); ++i)
    if (scene.parts[i].name == name) return static_cast<PartId>(i);
  return kNoPart;
}

}  // namespace tandem::assets
