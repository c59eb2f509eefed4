#pragma once

// A prepared scene as bytes: what the server sends to the sites, and what the cache keeps. Compressed (zstd),
// versioned, self-checking. Reading one is as suspicious as reading a file: the bytes may come from a
// network.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// BLAKE2b-256 of some content.
using ContentHash = std::array<std::uint8_t, 32>;

ContentHash contentHash(std::span<const std::byte> bytes);
/// The same of all pieces that `next` gives, one after the other, up to an empty one.
ContentHash hashOfPieces(const std::function<std::span<const std::byte>()>& next);
std::string toHex(const ContentHash& hash);

/// The scene as bytes; the same scene gives the same bytes on every machine of the same byte order.
std::vector<std::byte> packScene(const Scene& scene);

/// The scene of a package, with every count, index and number checked; an error names what is wrong.
Result<Scene> unpackScene(std::span<const std::byte> package);

}  // namespace tandem::assets
