#include "assets/scene/scene_package.h"

#include <algorithm>
#include <cstring>

#include <sodium.h>
#include <zstd.h>

#include "assets/scene/scene_codec.h"

namespace tandem::assets {
namespace {

constexpr char kMagic[8] = {'T', 'A', 'N', 'D', 'E', 'M', 'S', 'C'};
constexpr std::uint32_t kVersion = 7;  // of the package; raised whenever encodeScene() changes
// A package may unpack to so many times its length; one that compresses better is stored as it is, so that
// the bound never hits an honest scene.
constexpr std::uint64_t kMaxRatio = 1000;
constexpr std::uint64_t kMaxRaw = std::uint64_t{4} << 30;
constexpr int kLevel = 1;

/// Stands before the content, byte by byte.
struct Header {
  char magic[8];
  std::uint32_t version;
  std::uint32_t compressed;  // 1 = zstd, 0 = stored
  std::uint64_t rawSize;
  ContentHash hash;  // of the content as it stands in the package
};
static_assert(sizeof(Header) == 56);

Error bad(const std::string& reason) { return Error{"scene package: " + reason}; }

}  // namespace

ContentHash contentHash(std::span<const std::byte> bytes) {
  ContentHash hash;
  crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const unsigned char*>(bytes.data()),
                     bytes.size(), nullptr, 0);
  return hash;
}

std::string toHex(const ContentHash& hash) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : hash) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

std::vector<std::byte> packScene(const Scene& scene) {
  const std::vector<std::byte> raw = encodeScene(scene);
  std::vector<std::byte> package(sizeof(Header) + ZSTD_compressBound(raw.size()));
  std::size_t size = ZSTD_compress(package.data() + sizeof(Header), package.size() - sizeof(Header),
                                   raw.data(), raw.size(), kLevel);
  const bool compressed = ZSTD_isError(size) == 0 && size < raw.size() && raw.size() / kMaxRatio < size;
  if (!compressed) {
    size = raw.size();
    package.resize(sizeof(Header) + size);
    std::copy(raw.begin(), raw.end(), package.begin() + sizeof(Header));
  }
  package.resize(sizeof(Header) + size);
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.version = kVersion;
  header.compressed = compressed ? 1 : 0;
  header.rawSize = raw.size();
  header.hash = contentHash(std::span<const std::byte>(package).subspan(sizeof(Header)));
  std::memcpy(package.data(), &header, sizeof header);
  return package;
}

Result<Scene> unpackScene(std::span<const std::byte> package) {
  Header header;
  if (package.size() < sizeof header) return bad("it is truncated");
  std::memcpy(&header, package.data(), sizeof header);
  const std::span<const std::byte> content = package.subspan(sizeof header);
  if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0) return bad("it does not begin as one");
  if (header.version != kVersion) return bad("version " + std::to_string(header.version) + " is unknown");
  if (header.compressed > 1) return bad("the compression is unknown");
  if (header.hash != contentHash(content)) return bad("it is damaged: its hash does not match");
  if (header.rawSize > kMaxRaw) return bad("it claims to unpack to more than 4 GiB");
  std::vector<std::byte> unpacked;
  std::span<const std::byte> raw = content;
  if (header.compressed == 1) {
    if (header.rawSize / kMaxRatio >= content.size() + 1)
      return bad("it claims to unpack to more than its length allows");
    unpacked.resize(header.rawSize);
    const std::size_t size =
        ZSTD_decompress(unpacked.data(), unpacked.size(), content.data(), content.size());
    if (ZSTD_isError(size) != 0 || size != header.rawSize) return bad("its content cannot be decompressed");
    raw = unpacked;
  }
  if (raw.size() != header.rawSize) return bad("its length is not the one it states");
  Result<Scene> scene = decodeScene(raw);
  if (!scene) return bad(scene.error().message);
  return scene;
}

}  // namespace tandem::assets
