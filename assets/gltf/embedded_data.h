#pragma once

// Data that stands inside a glTF file in an encoding of its own: data URIs and images. The one source that
// decodes by tinygltf. For the loader's sources only.

#include <optional>
#include <string>
#include <vector>

#include "assets/scene/surface.h"

namespace tandem::assets {

/// The bytes of a data URI; nothing where the text is none or cannot be decoded.
std::optional<std::vector<unsigned char>> decodeDataUri(const std::string& uri);

/// The red channel of a PNG or JPEG image, at most kMaxTextureSide texels a side; nothing where it cannot be
/// read.
std::optional<TextureImage> decodeImage(const std::vector<unsigned char>& bytes);

}  // namespace tandem::assets
