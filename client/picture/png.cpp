#include "client/picture/png.h"

// Static: a shared library that tinygltf brings along holds the same functions.
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

#include "assets/base/assert.h"

namespace tandem::client {

namespace {

/// The last row of pixels. A negative stride from it turns the picture upright without copying it.
const std::uint8_t* topRow(int width, int height, const std::vector<std::uint8_t>& rgb) {
  const auto stride = static_cast<std::size_t>(3 * width), rows = static_cast<std::size_t>(height);
  ASSERT(width > 0 && height > 0 && rgb.size() == stride * rows);
  return rgb.data() + stride * (rows - 1);
}

}  // namespace

Status writePng(const std::string& path, int width, int height, const std::vector<std::uint8_t>& rgb) {
  if (stbi_write_png(path.c_str(), width, height, 3, topRow(width, height, rgb), -3 * width) == 0)
    return Error{path + ": the picture cannot be written"};
  return {};
}

std::vector<std::uint8_t> encodePng(int width, int height, const std::vector<std::uint8_t>& rgb) {
  std::vector<std::uint8_t> png;
  const auto append = [](void* context, void* data, int size) {
    auto& bytes = *static_cast<std::vector<std::uint8_t>*>(context);
    const auto* begin = static_cast<const std::uint8_t*>(data);
    bytes.insert(bytes.end(), begin, begin + size);
  };
  stbi_write_png_to_func(append, &png, width, height, 3, topRow(width, height, rgb), -3 * width);
  return png;
}

}  // namespace tandem::client
