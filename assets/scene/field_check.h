#pragma once

#include <string>

#include "assets/base/result.h"
#include "assets/scene/force_field.h"

namespace tandem::assets {

/// Whether the haptic tick can use every number of a field, for data from a file or a wire. `parts` is the
/// number of parts in the scene; the message names `place`.
Status checkField(const ForceField& field, std::size_t parts, const std::string& place);

}  // namespace tandem::assets
