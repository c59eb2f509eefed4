#pragma once

// What the writer and the reader of BCF, the exchange format of buildingSMART, share: versions, axes, limits.

#include <cstddef>
#include <cstdint>

#include <glm/vec3.hpp>

namespace tandem::client {

enum class BcfVersion : std::uint8_t { v2_1, v3_0 };

/// BCF has +z up, a scene +y: a turn by 90 degrees about x.
inline glm::dvec3 bcfFromWorld(const glm::dvec3& v) { return {v.x, -v.z, v.y}; }
inline glm::dvec3 worldFromBcf(const glm::dvec3& v) { return {v.x, v.z, -v.y}; }

// What is beyond these is refused, whatever its archive says about itself.
inline constexpr std::size_t kMaxBcfBytes = std::size_t{256} << 20;  // of an archive
inline constexpr std::size_t kMaxBcfEntries = 65535;                 // files in it
inline constexpr std::size_t kMaxBcfTopics = 16384;
inline constexpr std::size_t kMaxBcfComments = 16384;                // of all topics
inline constexpr std::size_t kMaxXmlBytes = std::size_t{4} << 20;    // of a file that is read
inline constexpr std::size_t kMaxXmlTotal = std::size_t{128} << 20;  // of all
inline constexpr int kMaxXmlDepth = 16;

}  // namespace tandem::client
