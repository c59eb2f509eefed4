#include "haptics/scene/haptic_texture.h"

#include <cmath>
#include <cstdint>
#include <numbers>

#include <glm/geometric.hpp>

#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/force_shading.h"

namespace tandem::haptics {
namespace {

using Pattern = assets::SurfaceTexture::Pattern;

constexpr double kTurn = 2.0 * std::numbers::pi;

Height grid(const glm::dvec3& turns, double wavelength) {
  Height h;
  for (int i = 0; i < 3; ++i) {
    h.value += std::sin(kTurn * turns[i]) / 3.0;
    h.gradient[i] = std::cos(kTurn * turns[i]) * kTurn / (3.0 * wavelength);
  }
  return h;
}

Height bumps(const glm::dvec3& turns, double wavelength) {
  const glm::dvec3 off = turns - glm::floor(turns + 0.5);
  const double inside = 1.0 - 4.0 * glm::dot(off, off);
  if (!(inside > 0.0)) return {-1.0, {}, {}};
  return {2.0 * inside * inside - 1.0, off * (-32.0 * inside / wavelength), {}};
}

/// -1..1 for a lattice point, from a hash of its coordinates (the mixer of splitmix64).
double latticeValue(const glm::dvec3& p) {
  std::uint64_t h = 0;
  for (int i = 0; i < 3; ++i) {
    // Far beyond any scene the lattice repeats, because an out-of-range conversion would be undefined.
    h ^= static_cast<std::uint64_t>(static_cast<std::int64_t>(std::fmod(p[i], 0x1p52)));
    h = (h + 0x9e3779b97f4a7c15u) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
    h ^= h >> 31;
  }
  return static_cast<double>(h >> 11) * 0x1p-52 - 1.0;
}

Height noise(const glm::dvec3& turns, double wavelength) {
  const glm::dvec3 cell = glm::floor(turns), t = turns - cell;
  glm::dvec3 fade, slope;
  for (int i = 0; i < 3; ++i) {
    fade[i] = t[i] * t[i] * t[i] * (t[i] * (6.0 * t[i] - 15.0) + 10.0);
    slope[i] = 30.0 * t[i] * t[i] * (t[i] - 1.0) * (t[i] - 1.0) / wavelength;
  }
  Height h;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at(corner & 1, (corner >> 1) & 1, corner >> 2);
    const double value = latticeValue(cell + at);
    glm::dvec3 weight, change;
    for (int i = 0; i < 3; ++i) {
      weight[i] = at[i] > 0.0 ? fade[i] : 1.0 - fade[i];
      change[i] = at[i] > 0.0 ? slope[i] : -slope[i];
    }
    h.value += value * weight.x * weight.y * weight.z;
    h.gradient += value * glm::dvec3(change.x * weight.y * weight.z, weight.x * change.y * weight.z,
                                     weight.x * weight.y * change.z);
  }
  return h;
}

}  // namespace

Height patternHeight(Pattern pattern, double wavelength, const glm::dvec3& x) {
  const glm::dvec3 turns = x / wavelength;
  switch (pattern) {
    case Pattern::sine:
      return {std::sin(kTurn * turns.x), {std::cos(kTurn * turns.x) * kTurn / wavelength, 0.0, 0.0}, {}};
    case Pattern::grid:
      return grid(turns, wavelength);
    case Pattern::bumps:
      return bumps(turns, wavelength);
    case Pattern::noise:
      return noise(turns, wavelength);
    case Pattern::none:
    case Pattern::image:
      break;
  }
  return {};
}

Height imageHeight(const assets::TextureImage& image, const glm::dvec2& uv) {
  const glm::dvec2 size(image.width, image.height);
  // Texel i covers i..i+1; its value is that at i + 1/2.
  const glm::dvec2 at = (uv - glm::floor(uv)) * size - 0.5;
  const glm::dvec2 base = glm::floor(at), t = at - base;
  const auto texel = [&](double x, double y) {
    const auto column = static_cast<std::uint32_t>(x < 0.0 ? x + size.x : x) % image.width;
    const auto row = static_cast<std::uint32_t>(y < 0.0 ? y + size.y : y) % image.height;
    return image.texels[std::size_t{row} * image.width + column] * (2.0 / 255.0) - 1.0;
  };
  const double a = texel(base.x, base.y), b = texel(base.x + 1.0, base.y);
  const double c = texel(base.x, base.y + 1.0), d = texel(base.x + 1.0, base.y + 1.0);
  Height h;
  h.value = (a * (1.0 - t.x) + b * t.x) * (1.0 - t.y) + (c * (1.0 - t.x) + d * t.x) * t.y;
  h.uvGradient.x = ((b - a) * (1.0 - t.y) + (d - c) * t.y) * size.x;
  h.uvGradient.y = ((c - a) * (1.0 - t.x) + (d - b) * t.x) * size.y;
  return h;
}

FacetHeight imageHeightOnFacet(const assets::TextureImage& image, const std::array<glm::vec2, 3>& uv,
                               double u, double v) {
  const glm::dvec2 origin(uv[0]), alongU = glm::dvec2(uv[1]) - origin, alongV = glm::dvec2(uv[2]) - origin;
  const Height h = imageHeight(image, origin + u * alongU + v * alongV);
  return {h.value, glm::dot(h.uvGradient, alongU), glm::dot(h.uvGradient, alongV)};
}

std::optional<Height> heightOnFacet(const assets::Scene& scene, const assets::SurfaceTexture& texture,
                                    const assets::Mesh& mesh, std::uint32_t triangle,
                                    const glm::dvec3& place) {
  if (texture.pattern != Pattern::image) return patternHeight(texture.pattern, texture.wavelength, place);
  PatchPoint onFacet;
  if (triangle >= mesh.triangleUv.size() ||
      !projectOntoPatch(mesh, nullptr, triangle, place, place, 1.0, onFacet))
    return std::nullopt;
  const FacetHeight h =
      imageHeightOnFacet(scene.textures[texture.image], mesh.triangleUv[triangle], onFacet.u, onFacet.v);
  return Height{h.value, h.byU * onFacet.uGradient + h.byV * onFacet.vGradient, {}};
}

double textureFriction(const ContactWorld& world, PartId part, std::uint32_t triangle,
                       const glm::dvec3& place) {
  const assets::Scene& scene = world.scene();
  const assets::Material& material = world.material(part, triangle);
  if (material.surface >= scene.surfaces.size()) return 1.0;
  const assets::SurfaceTexture& texture = scene.surfaces[material.surface].texture;
  if (texture.frictionScale == 1.0 || texture.pattern == Pattern::none) return 1.0;
  const auto height = heightOnFacet(scene, texture, world.collider(part).tree->mesh(), triangle, place);
  return height ? 1.0 + (texture.frictionScale - 1.0) * 0.5 * (height->value + 1.0) : 1.0;
}

}  // namespace tandem::haptics
