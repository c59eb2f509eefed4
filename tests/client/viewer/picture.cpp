#include "tests/client/viewer/picture.h"

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#include <stb/stb_image.h>

#include <algorithm>
#include <cstdlib>

namespace tandem::client {

Rgb Picture::at(int x, int y) const {
  if (x < 0 || y < 0 || x >= width || y >= height) return {-1, -1, -1};
  const auto i =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

int Picture::count(const std::function<bool(const Rgb&)>& condition) const {
  int n = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) n += condition(at(x, y)) ? 1 : 0;
  return n;
}

Picture readPng(const std::string& path) {
  Picture picture;
  int channels = 0;
  stbi_uc* data = stbi_load(path.c_str(), &picture.width, &picture.height, &channels, 3);
  if (!data) return {};
  picture.rgb.assign(data, data + std::size_t{3} * static_cast<std::size_t>(picture.width) *
                                      static_cast<std::size_t>(picture.height));
  stbi_image_free(data);
  return picture;
}

int countDifferent(const Picture& a, const Picture& b, int tolerance) {
  int n = 0;
  for (int y = 0; y < std::max(a.height, b.height); ++y)
    for (int x = 0; x < std::max(a.width, b.width); ++x) {
      const Rgb p = a.at(x, y), q = b.at(x, y);
      bool differs = false;
      for (std::size_t k = 0; k < 3; ++k) differs = differs || std::abs(p[k] - q[k]) > tolerance;
      n += differs ? 1 : 0;
    }
  return n;
}

}  // namespace tandem::client
