#include "client/viewer/png.h"

// Static: a shared library that tinygltf brings along holds the same functions.
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

#include "assets/base/assert.h"

namespace tandem::client {

Status writePng(const std::string& path, int width, int height, const std::vector<std::uint8_t>& rgb) {
  const int stride = 3 * width;
  ASSERT(width > 0 && height > 0);
  ASSERT(rgb.size() == static_cast<std::size_t>(stride) * static_cast<std::size_t>(height));
  // A negative stride from the last row turns the picture upright without copying it.
  const std::uint8_t* topRow =
      rgb.data() + static_cast<std::size_t>(stride) * static_cast<std::size_t>(height - 1);
  if (stbi_write_png(path.c_str(), width, height, 3, topRow, -stride) == 0)
    return Error{path + ": the picture cannot be written"};
  return {};
}

}  // namespace tandem::client
