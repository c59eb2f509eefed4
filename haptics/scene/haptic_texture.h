#pragma once

// Relief textures: heights and their gradients, from an image or a formula, and the friction maps that go by
// these heights.

#include <array>
#include <cstdint>
#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "assets/scene/scene.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// A height and its gradient.
struct Height {
  double value = 0.0;                  // in units of the amplitude, -1..1
  glm::dvec3 gradient{0.0, 0.0, 0.0};  // 1/m, by the place in the part frame; for formulas
  glm::dvec2 uvGradient{0.0, 0.0};     // by the texture coordinates; for images
};

/// Height of a formula at place x (m, part frame) with wavelength w: sine is sin(2 pi x / w); grid is the
/// mean of the three; bumps is 2 (1 - 4 r^2)^2 - 1 around the points of a cubic lattice of pitch w, with r
/// their distance / w, and -1 from r = 1/2 on; noise blends values at the lattice's points with 6 t^5 - 15
/// t^4 + 10 t^3 (Perlin 2002).
Height patternHeight(assets::SurfaceTexture::Pattern pattern, double wavelength, const glm::dvec3& x);

/// Height of an image at texture coordinates uv, bilinear between the centres of its texels and repeated
/// without end; 0 is -1, 255 is 1.
Height imageHeight(const assets::TextureImage& image, const glm::dvec2& uv);

/// A height over a facet, in units of the amplitude, with its derivatives by the barycentric coordinates u
/// and v of corners 1 and 2.
struct FacetHeight {
  double value = 0.0, byU = 0.0, byV = 0.0;
};

/// Height of an image on a facet whose corners have the texture coordinates `uv`.
FacetHeight imageHeightOnFacet(const assets::TextureImage& image, const std::array<glm::vec2, 3>& uv,
                               double u, double v);

/// Height of a texture with a pattern at a place (m, part frame) of one facet, with its gradient there; none
/// where an image has no coordinates.
std::optional<Height> heightOnFacet(const assets::Scene& scene, const assets::SurfaceTexture& texture,
                                    const assets::Mesh& mesh, std::uint32_t triangle,
                                    const glm::dvec3& place);

/// Factor that a relief texture with a friction map applies to the coefficients at a place (m, part frame) of
/// one triangle; 1 elsewhere.
double textureFriction(const ContactWorld& world, PartId part, std::uint32_t triangle,
                       const glm::dvec3& place);

/// Factor on both friction coefficients at one point of a surface, >= 0. Scenes without surfaces pay for one
/// comparison.
inline double frictionScale(const ContactWorld& world, const SurfacePoint& at) {
  if (world.surfaces() == nullptr) return 1.0;
  return textureFriction(world, at.part, at.triangle, transformPoint(inverse(world.pose(at.part)), at.point));
}

}  // namespace tandem::haptics
