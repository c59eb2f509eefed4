#pragma once

// Colours that tell parts apart, instead of those of the file. Who holds a part is told by colour all the
// same.

#include <optional>

#include <glm/vec3.hpp>

#include "assets/document/entry.h"
#include "assets/scene/scene.h"

namespace tandem::client {

using document::PartColouring;

/// sRGB of a part; nothing: as made.
std::optional<glm::vec3> colourOf(const assets::Scene& scene, PartId part, PartColouring colouring);

}  // namespace tandem::client
