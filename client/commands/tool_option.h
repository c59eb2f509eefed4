#pragma once

// The option --tool of commands: what a hand touches with when it holds nothing.

#include <optional>
#include <string>

#include "assets/base/result.h"

namespace tandem::client {

/// Radius of `point` (0) or `ball:RADIUS_M`, m; none for an empty text. `forms` names in errors what the
/// command takes.
Result<std::optional<double>> parseTip(const std::string& text, const char* forms = "point or ball:RADIUS_M");

}  // namespace tandem::client
