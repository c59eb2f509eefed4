#include "assets/generate/grey_png.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace tandem::generate {
namespace {

using Bytes = std::vector<unsigned char>;

void putBig(Bytes& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<unsigned char>(value >> shift));
}

/// CRC-32 of a PNG chunk (PNG, 5.5).
std::uint32_t crc(const unsigned char* begin, const unsigned char* end) {
  std::uint32_t c = 0xffffffffu;
  for (const unsigned char* p = begin; p != end; ++p) {
    c ^= *p;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1u) != 0 ? 0xedb88320u ^ (c >> 1) : c >> 1;
  }
  return ~c;
}

void putChunk(Bytes& out, const char (&type)[5], const Bytes& data) {
  putBig(out, static_cast<std::uint32_t>(data.size()));
  const std::size_t start = out.size();
  out.insert(out.end(), type, type + 4);
  out.insert(out.end(), data.begin(), data.end());
  putBig(out, crc(out.data() + start, out.data() + out.size()));
}

/// Adler-32 (RFC 1950).
std::uint32_t checksum(const Bytes& data) {
  std::uint32_t a = 1, b = 0;
  for (const unsigned char byte : data) {
    a = (a + byte) % 65521u;
    b = (b + a) % 65521u;
  }
  return b << 16 | a;
}

/// A zlib stream of stored blocks.
Bytes stored(const Bytes& data) {
  constexpr std::size_t kBlock = 65535;
  Bytes out = {0x78, 0x01};
  for (std::size_t at = 0; at < data.size(); at += kBlock) {
    const std::size_t length = std::min(kBlock, data.size() - at);
    out.push_back(at + length == data.size() ? 1 : 0);
    for (const std::size_t n : {length, ~length}) {
      out.push_back(static_cast<unsigned char>(n));
      out.push_back(static_cast<unsigned char>(n >> 8));
    }
    out.insert(out.end(), data.begin() + static_cast<std::ptrdiff_t>(at),
               data.begin() + static_cast<std::ptrdiff_t>(at + length));
  }
  putBig(out, checksum(data));
  return out;
}

}  // namespace

std::vector<unsigned char> greyPng(const assets::TextureImage& image) {
  Bytes out = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  Bytes head;
  putBig(head, image.width);
  putBig(head, image.height);
  head.insert(head.end(), {8, 0, 0, 0, 0});  // 8 bits, grey, deflate, no interlace
  putChunk(out, "IHDR", head);
  Bytes rows;
  for (std::size_t y = 0; y < image.height; ++y) {
    rows.push_back(0);  // no filter
    const auto row = image.texels.begin() + static_cast<std::ptrdiff_t>(y * image.width);
    rows.insert(rows.end(), row, row + static_cast<std::ptrdiff_t>(image.width));
  }
  putChunk(out, "IDAT", stored(rows));
  putChunk(out, "IEND", {});
  return out;
}

}  // namespace tandem::generate
