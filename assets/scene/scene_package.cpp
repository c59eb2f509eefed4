#include "assets/scene/scene_package.h"

#include <cstring>
#include <memory>

#include <sodium.h>
#include <zstd.h>

#include "assets/base/assert.h"
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

// A scene of ten million triangles is 0.4 GB before it is compressed: neither way is all of that kept at
// once.

/// Room for a header, and the scene compressed; `rawSize` becomes its length before.
std::vector<std::byte> compressed(const Scene& scene, std::uint64_t& rawSize) {
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), &ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel);
  std::vector<std::byte> package(sizeof(Header)), chunk(ZSTD_CStreamOutSize());
  rawSize = 0;
  const auto pass = [&](std::span<const std::byte> piece, ZSTD_EndDirective directive) {
    ZSTD_inBuffer in{piece.data(), piece.size(), 0};
    std::size_t left = 1;
    while (left > 0 && (directive == ZSTD_e_end || in.pos < in.size)) {
      ZSTD_outBuffer out{chunk.data(), chunk.size(), 0};
      left = ZSTD_compressStream2(context.get(), &out, &in, directive);
      ASSERT(ZSTD_isError(left) == 0);
      package.insert(package.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(out.pos));
      if (directive == ZSTD_e_continue) left = 1;
    }
    rawSize += piece.size();
  };
  encodeScene(scene, [&](std::span<const std::byte> piece) { pass(piece, ZSTD_e_continue); });
  pass({}, ZSTD_e_end);
  return package;
}

class Decompressor {
 public:
  explicit Decompressor(std::span<const std::byte> content)
      : context_(ZSTD_createDCtx(), &ZSTD_freeDCtx), in_{content.data(), content.size(), 0} {}

  /// The next bytes; false if there are not as many.
  bool fill(std::span<std::byte> piece) {
    ZSTD_outBuffer out{piece.data(), piece.size(), 0};
    while (out.pos < out.size && !failed_) {
      const std::size_t before = out.pos + in_.pos;
      step(out);
      if (out.pos + in_.pos == before) failed_ = true;
    }
    return !failed_;
  }
  bool failed() const { return failed_; }
  /// Whether nothing follows: neither bytes nor another frame.
  bool atEnd() {
    std::byte one{};
    ZSTD_outBuffer out{&one, 1, 0};
    if (!ended_) step(out);
    return !failed_ && ended_ && out.pos == 0 && in_.pos == in_.size;
  }

 private:
  void step(ZSTD_outBuffer& out) {
    const std::size_t hint = ZSTD_decompressStream(context_.get(), &out, &in_);
    failed_ = failed_ || ZSTD_isError(hint) != 0;
    ended_ = hint == 0;
  }

  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context_;
  ZSTD_inBuffer in_;
  bool failed_ = false, ended_ = false;
};

Error bad(const std::string& reason) { return Error{"scene package: " + reason}; }

}  // namespace

ContentHash contentHash(std::span<const std::byte> bytes) {
  ContentHash hash;
  crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const unsigned char*>(bytes.data()),
                     bytes.size(), nullptr, 0);
  return hash;
}

ContentHash hashOfPieces(const std::function<std::span<const std::byte>()>& next) {
  ContentHash hash;
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, hash.size());
  for (auto piece = next(); !piece.empty(); piece = next())
    crypto_generichash_update(&state, reinterpret_cast<const unsigned char*>(piece.data()), piece.size());
  crypto_generichash_final(&state, hash.data(), hash.size());
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
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.version = kVersion;
  header.compressed = 1;
  std::vector<std::byte> package = compressed(scene, header.rawSize);
  const std::size_t size = package.size() - sizeof(Header);
  if (size >= header.rawSize || header.rawSize / kMaxRatio >= size) {
    header.compressed = 0;
    package.resize(sizeof(Header));
    encodeScene(scene, [&](std::span<const std::byte> piece) {
      package.insert(package.end(), piece.begin(), piece.end());
    });
  }
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
  if (header.compressed == 0) {
    if (content.size() != header.rawSize) return bad("its length is not the one it states");
    Result<Scene> scene = decodeScene(content);
    if (!scene) return bad(scene.error().message);
    return scene;
  }
  if (header.rawSize / kMaxRatio >= content.size() + 1)
    return bad("it claims to unpack to more than its length allows");
  Decompressor decompressor(content);
  Result<Scene> scene =
      decodeScene(header.rawSize, [&](std::span<std::byte> piece) { return decompressor.fill(piece); });
  if (decompressor.failed()) return bad("its content cannot be decompressed");
  if (!scene) return bad(scene.error().message);
  if (!decompressor.atEnd()) return bad("its length is not the one it states");
  return scene;
}

}  // namespace tandem::assets
