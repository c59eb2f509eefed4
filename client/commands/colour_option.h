#pragma once

// The option --colour: a person's colour.

#include <string>

#include "assets/base/result.h"
#include "sync/wire/site_colours.h"

namespace tandem::client {

/// "#RRGGBB". Black becomes nearly black, because zero leaves the choice to the server.
Result<sync::SiteColour> parseColour(const std::string& text);

}  // namespace tandem::client
