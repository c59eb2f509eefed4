#include "client/marks/part_colouring.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "assets/base/assert.h"

namespace tandem::client {

namespace {

constexpr glm::vec3 kPale(0.86f, 0.87f, 0.89f);

/// Neighbours in a sequence are far apart in hue: steps of the golden ratio round the circle, in three
/// lightnesses. The colours are muted, so that people's stand out.
glm::vec3 colourNumber(std::uint32_t number) {
  constexpr double kGolden = 0.61803398875;
  constexpr std::array<float, 3> kLight{0.72f, 0.58f, 0.84f};
  const double hue = 6.0 * std::fmod(0.08 + kGolden * number, 1.0);
  const float value = kLight[(number / 7) % kLight.size()], chroma = 0.42f * value;
  const auto channel = [&](double from) {
    const double distance = std::abs(std::remainder(hue - from, 6.0));
    const auto share = static_cast<float>(std::clamp(2.0 - distance, 0.0, 1.0));
    return value - chroma * (1.0f - share);
  };
  return {channel(0.0), channel(2.0), channel(4.0)};
}

std::uint32_t firstMaterial(const assets::Scene& scene, const assets::Part& part) {
  if (part.mesh == assets::kNone || scene.meshes[part.mesh].triangleMaterial.empty()) return 0;
  return scene.meshes[part.mesh].triangleMaterial.front();
}

}  // namespace

std::optional<glm::vec3> colourOf(const assets::Scene& scene, PartId part, PartColouring colouring) {
  if (colouring == PartColouring::asMade) return std::nullopt;
  if (colouring == PartColouring::byOwner) return kPale;
  ASSERT(part < scene.parts.size());
  const assets::Part& shown = scene.parts[part];
  if (colouring == PartColouring::byMaterial) return colourNumber(firstMaterial(scene, shown));
  return colourNumber(shown.mesh == assets::kNone ? static_cast<std::uint32_t>(scene.meshes.size()) + part
                                                  : shown.mesh);
}

}  // namespace tandem::client
