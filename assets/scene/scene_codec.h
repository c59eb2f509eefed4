#pragma once

// A scene as plain bytes, before compression and hashing; scene_package.h wraps them.
//
// Little-endian, fields in the order of scene.h. Arrays of integers are differences to a predicted value, and
// arrays of numbers wider than a byte are laid out in planes (all first bytes, then all second bytes ...),
// which costs nothing and halves what zstd makes of them.

#include <cstddef>
#include <span>
#include <vector>

#include "assets/base/result.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

std::vector<std::byte> encodeScene(const Scene& scene);

/// The scene in `bytes`, which may hold anything: counts are checked against the bytes that are left before
/// anything is allocated, the whole result by checkScene().
Result<Scene> decodeScene(std::span<const std::byte> bytes);

}  // namespace tandem::assets
