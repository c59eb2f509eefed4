#pragma once

// Data that a glTF file holds in another encoding: data URIs and images. embedded_data.cpp is the one source
// that decodes with tinygltf. For the loader's sources only.

#include <optional>
#include <string>
#include <vector>

#include "assets/scene/surface.h"

namespace tandem::assets {

/// The bytes of a data URI; nothing where the text is not a data URI or cannot be decoded.
std::optional<std::vector<unsigned char>> decodeDataUri(const std::string& uri);

/// The red channel of a PNG or JPEG image, at most kMaxTextureSide texels a side; nothing where it cannot be
/// read.
std::optional<TextureImage> decodeImage(const std::vector<unsigned char>& bytes);

}  // namespace tandem::assets
