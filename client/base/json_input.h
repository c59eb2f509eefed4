#pragma once

// JSON that people and other programs write: scenarios and hand scripts. Any thread.

#include <string>

#include "assets/base/json.h"
#include "assets/base/result.h"

namespace tandem::client {

/// The whole of a regular file; errors name it.
Result<std::string> readTextFile(const std::string& path);

/// Parses hostile text: an error names `source`, the line and the reason. Deep nesting is refused, because
/// what walks the tree afterwards recurses.
Result<Json> parseJson(const std::string& text, const std::string& source);

}  // namespace tandem::client
