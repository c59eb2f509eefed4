#pragma once

// A grey image as the bytes of a PNG file.

#include <vector>

#include "assets/scene/surface.h"

namespace tandem::generate {

/// Writes 8 bits a texel without compression, so that the bytes depend on no compression library (PNG, 3rd
/// edition; RFC 1950 and 1951 for the stream of stored blocks). `image` must have width * height texels.
std::vector<unsigned char> greyPng(const assets::TextureImage& image);

}  // namespace tandem::generate
