#pragma once

// Files of other CAD formats, which people try first.

#include <span>
#include <string>

namespace tandem::assets {

/// "a STEP", "an IGES", "an STL" or "an OBJ" for a file that is one by its first bytes, or by the end of its
/// name if it does not begin like glTF; else null.
const char* foreignFormat(const std::string& path, std::span<const unsigned char> file);

}  // namespace tandem::assets
