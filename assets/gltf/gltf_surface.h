#pragma once

// Reads the surface properties of extras.haptic and the images that they name. For the loader's sources only.

#include <cstdint>
#include <string>
#include <vector>

#include "assets/gltf/gltf_document.h"
#include "assets/gltf/gltf_json.h"
#include "assets/scene/surface.h"

namespace tandem::assets {

/// Properties that the loader does not know, most likely misspelt.
struct UnknownProperties {
  std::uint64_t count = 0;
  std::string names;  // of the first few, printable

  void add(const std::string& name);
};

/// Reads the properties of `haptic` that make up a Surface; texture.image becomes a glTF texture index,
/// checked. Throws GltfError where a known property has a wrong type or sign, or is outside of its range.
void readSurface(const JsonObject& haptic, const Json& document, Surface& surface,
                 UnknownProperties& unknown);

/// Decodes the images of all surfaces and turns their texture indices into those of the result. A surface
/// whose image cannot be read (not PNG or JPEG, a file of its own, too large) loses its texture; `unread`
/// counts them.
std::vector<TextureImage> readTextures(const GltfDocument& document, std::vector<Surface>& surfaces,
                                       std::uint64_t& unread);

}  // namespace tandem::assets
