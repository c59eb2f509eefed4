#pragma once

#include <string>

#include "assets/base/result.h"
#include "assets/scene/force_field.h"

namespace tandem::assets {

/// Whether every number of a field is one that the haptic tick can work with: for data that came over a
/// wire. `parts` is how many parts the scene has; `place` stands in the message.
Status checkField(const ForceField& field, std::size_t parts, const std::string& place);

}  // namespace tandem::assets
