#pragma once

// The builder of assets/generate, under the tests' names.

#include "assets/generate/soup_builder.h"

namespace tandem::test {

using generate::Ring;
using generate::SoupBuilder;

}  // namespace tandem::test
