#pragma once

// The irregular solids of assets/generate, under the tests' names.

#include <random>

#include "assets/generate/irregular_shapes.h"
#include "tests/support/part_meshes.h"
#include "tests/support/random_numbers.h"
#include "tests/support/soup_builder.h"

namespace tandem::test {

using Random = std::mt19937;
using generate::blobSoup;
using generate::Family;
using generate::familyName;
using generate::irregularMesh;

}  // namespace tandem::test
