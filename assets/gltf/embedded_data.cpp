#include "assets/gltf/embedded_data.h"

#include <algorithm>
#include <iterator>

#include <tiny_gltf.h>

namespace tandem::assets {
namespace {

std::uint32_t bigEndian(const std::vector<unsigned char>& bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8 | bytes[at + i];
  return value;
}

/// Whether the header states a size within the limit, so that a few bytes cannot demand gigabytes.
bool modestSize(const std::vector<unsigned char>& bytes) {
  static constexpr unsigned char kPng[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const auto fits = [](std::uint32_t side) { return side > 0 && side <= kMaxTextureSide; };
  if (bytes.size() >= 24 && std::equal(std::begin(kPng), std::end(kPng), bytes.begin()))
    return fits(bigEndian(bytes, 16, 4)) && fits(bigEndian(bytes, 20, 4));
  if (bytes.size() < 4 || bytes[0] != 0xff || bytes[1] != 0xd8) return false;
  // JPEG: a chain of segments; the size stands in the frame's (ITU T.81, B.2.2).
  for (std::size_t at = 2; at + 9 <= bytes.size() && bytes[at] == 0xff;) {
    const unsigned marker = bytes[at + 1];
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return fits(bigEndian(bytes, at + 5, 2)) && fits(bigEndian(bytes, at + 7, 2));
    at += 2 + bigEndian(bytes, at + 2, 2);
  }
  return false;
}

}  // namespace

std::optional<std::vector<unsigned char>> decodeDataUri(const std::string& uri) {
  std::vector<unsigned char> bytes;
  std::string mimeType;
  if (!tinygltf::IsDataURI(uri) || !tinygltf::DecodeDataURI(&bytes, mimeType, uri, 0, false))
    return std::nullopt;
  return bytes;
}

std::optional<TextureImage> decodeImage(const std::vector<unsigned char>& bytes) {
  if (!modestSize(bytes)) return std::nullopt;
  tinygltf::Image image;
  std::string error, warning;
  if (!tinygltf::LoadImageData(&image, 0, &error, &warning, 0, 0, bytes.data(),
                               static_cast<int>(bytes.size()), nullptr))
    return std::nullopt;
  const std::size_t count = std::size_t(std::max(image.width, 0)) * std::size_t(std::max(image.height, 0));
  const std::size_t channels = static_cast<std::size_t>(std::max(image.component, 0));
  const std::size_t step = channels * static_cast<std::size_t>(image.bits / 8);
  if (count == 0 || channels == 0 || (image.bits != 8 && image.bits != 16) ||
      image.image.size() < count * step)
    return std::nullopt;
  TextureImage out;
  out.width = static_cast<std::uint32_t>(image.width);
  out.height = static_cast<std::uint32_t>(image.height);
  out.texels.resize(count);
  // Height maps are grey, so the red channel suffices. Of 16 bits the upper eight are used; they come second
  // in memory.
  const std::size_t high = image.bits == 16 ? 1 : 0;
  for (std::size_t i = 0; i < count; ++i) out.texels[i] = image.image[i * step + high];
  return out;
}

}  // namespace tandem::assets
