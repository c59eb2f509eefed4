#pragma once

// How a site fetches the scene package.

#include <cstdint>
#include <vector>

namespace tandem::sync {

/// Asks for bytes of the scene package from `offset` on; the server sends SceneChunks until the end or a new
/// request.
struct SceneRequest {
  std::uint64_t offset = 0;
};

struct SceneChunk {
  std::uint64_t offset = 0;
  std::vector<std::uint8_t> bytes;  // 1..kMaxChunkBytes
};

}  // namespace tandem::sync
