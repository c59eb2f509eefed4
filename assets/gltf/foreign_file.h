#pragma once

// Recognises files that are not glTF, for a message that says what they are and what helps.

#include <optional>
#include <span>
#include <string>

namespace tandem::assets {

/// What a file is that does not begin like glTF, and what helps: by its beginning, or by the end of its
/// name. Nothing for what begins like glTF, and for an empty file.
std::optional<std::string> foreignFile(const std::string& path, std::span<const unsigned char> file);

}  // namespace tandem::assets
