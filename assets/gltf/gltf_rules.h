#pragma once

// The types and references that the loader relies on, checked over the whole document at once. For the
// loader's sources only.

#include "assets/base/json.h"

namespace tandem::assets {

/// Checks that every property of the core sections that the loader reads has its type and that every index is
/// in range; throws GltfError. Whole numbers that are written as 3.0, which is legal, become integers.
void checkRules(Json& document);

}  // namespace tandem::assets
