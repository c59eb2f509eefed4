#pragma once

// Colours that tell parts apart, instead of those of the file. Who holds a part is told by colour all the
// same.

#include <array>
#include <optional>

#include <glm/vec3.hpp>

#include "assets/scene/scene.h"

namespace tandem::client {

enum class PartColouring : std::uint8_t {
  asMade,
  byBody,      // parts of one mesh alike
  byMaterial,  // by that of a part's first face
  byOwner      // pale, but for those that somebody holds
};
inline constexpr std::array<const char*, 4> kColouringNames{"as made", "by body", "by material", "by owner"};

/// sRGB of a part; nothing: as made.
std::optional<glm::vec3> colourOf(const assets::Scene& scene, PartId part, PartColouring colouring);

}  // namespace tandem::client
