#pragma once

// Who does not believe whose motion, in words.

#include <string>

#include "client/session/view_model.h"

namespace tandem::client {

/// "does not move or push as a hand does, say Ada and you (2 of 3 other sites)"; empty if nobody says so.
std::string doubtsInWords(const ViewModel& model, const SiteView& site);

}  // namespace tandem::client
