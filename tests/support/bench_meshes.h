#pragma once

// The bench meshes of assets/generate, under the tests' names.

#include "assets/generate/bench_meshes.h"

namespace tandem::tests {

using namespace generate;

}  // namespace tandem::tests
