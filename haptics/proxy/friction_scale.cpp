#include "haptics/proxy/friction_scale.h"

#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/force_shading.h"
#include "haptics/scene/haptic_texture.h"

namespace tandem::haptics {

double textureFriction(const ContactWorld& world, const SurfacePoint& at) {
  const assets::Scene& scene = world.scene();
  const assets::Material& material = world.material(at.part, at.triangle);
  if (material.surface >= scene.surfaces.size()) return 1.0;
  using assets::SurfaceTexture;
  const SurfaceTexture& texture = scene.surfaces[material.surface].texture;
  if (texture.frictionScale == 1.0 || texture.pattern == SurfaceTexture::Pattern::none) return 1.0;
  const Pose& pose = world.pose(at.part);
  const glm::dvec3 x = glm::conjugate(pose.orientation) * (at.point - pose.position);
  if (texture.pattern != SurfaceTexture::Pattern::image)
    return frictionShare(texture, patternHeight(texture.pattern, texture.wavelength, x).value);
  const assets::Mesh& mesh = world.collider(at.part).tree->mesh();
  PatchPoint place;
  if (at.triangle >= mesh.triangleUv.size() ||
      !projectOntoPatch(mesh, nullptr, at.triangle, x, x, 1.0, place))
    return 1.0;
  return frictionShare(texture, imageHeightOnFacet(scene.textures[texture.image],
                                                   mesh.triangleUv[at.triangle], place.u, place.v)
                                    .value);
}

}  // namespace tandem::haptics
