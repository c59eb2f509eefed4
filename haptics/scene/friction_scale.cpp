#include "haptics/scene/friction_scale.h"

#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/force_shading.h"
#include "haptics/scene/haptic_texture.h"

namespace tandem::haptics {

double textureFriction(const ContactWorld& world, PartId part, std::uint32_t triangle,
                       const glm::dvec3& place) {
  const assets::Scene& scene = world.scene();
  const assets::Material& material = world.material(part, triangle);
  if (material.surface >= scene.surfaces.size()) return 1.0;
  using assets::SurfaceTexture;
  const SurfaceTexture& texture = scene.surfaces[material.surface].texture;
  if (texture.frictionScale == 1.0 || texture.pattern == SurfaceTexture::Pattern::none) return 1.0;
  if (texture.pattern != SurfaceTexture::Pattern::image)
    return frictionShare(texture, patternHeight(texture.pattern, texture.wavelength, place).value);
  const assets::Mesh& mesh = world.collider(part).tree->mesh();
  PatchPoint onFacet;
  if (triangle >= mesh.triangleUv.size() ||
      !projectOntoPatch(mesh, nullptr, triangle, place, place, 1.0, onFacet))
    return 1.0;
  return frictionShare(texture, imageHeightOnFacet(scene.textures[texture.image], mesh.triangleUv[triangle],
                                                   onFacet.u, onFacet.v)
                                    .value);
}

}  // namespace tandem::haptics
