#pragma once

// A scene as plain bytes, before compression and hashing; scene_package.h wraps them.
//
// Little-endian, fields in the order of scene.h. Arrays of integers are differences to a predicted value, and
// arrays of numbers wider than a byte are laid out in planes (all first bytes, then all second bytes ...),
// which costs nothing and halves what zstd makes of them.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "assets/base/result.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

std::vector<std::byte> encodeScene(const Scene& scene);

/// The same in pieces, one after the other, none much larger than the largest array of the scene.
using ByteSink = std::function<void(std::span<const std::byte>)>;
void encodeScene(const Scene& scene, const ByteSink& sink);

/// The scene in `bytes`, which may hold anything: counts are checked against the bytes that are left before
/// anything is allocated, the whole result by checkScene().
Result<Scene> decodeScene(std::span<const std::byte> bytes);

/// The same from a source that fills whole spans with the next of `size` bytes; false: it cannot.
using ByteSource = std::function<bool(std::span<std::byte>)>;
Result<Scene> decodeScene(std::uint64_t size, const ByteSource& source);

}  // namespace tandem::assets
