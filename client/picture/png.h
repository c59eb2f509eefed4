#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "assets/base/result.h"

namespace tandem::client {

/// Writes 8-bit RGB rows, bottom row first as GL gives them, as a PNG; the error names the file.
Status writePng(const std::string& path, int width, int height, const std::vector<std::uint8_t>& rgb);

/// The same picture as the bytes of a PNG file.
std::vector<std::uint8_t> encodePng(int width, int height, const std::vector<std::uint8_t>& rgb);

}  // namespace tandem::client
