#pragma once

// A grey image as the bytes of a PNG file.

#include <vector>

#include "assets/scene/surface.h"

namespace tandem::generate {

/// 8 bits a texel, not compressed: the same bytes whatever library of compression is there (PNG, 3rd edition;
/// RFC 1950 and 1951 for its stream of stored blocks). `image` must have as many texels as it says.
std::vector<unsigned char> greyPng(const assets::TextureImage& image);

}  // namespace tandem::generate
