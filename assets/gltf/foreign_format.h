#pragma once

// Recognises files of other CAD formats, for a helpful message.

#include <span>
#include <string>

namespace tandem::assets {

/// "a STEP", "an IGES", "an STL" or "an OBJ" by the file's first bytes, or by the end of its name if the file
/// does not begin like glTF; null for any other file.
const char* foreignFormat(const std::string& path, std::span<const unsigned char> file);

}  // namespace tandem::assets
