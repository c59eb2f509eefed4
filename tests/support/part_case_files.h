#pragma once

// A case of part contact as the files that the command line takes: SCENE.glb and PATH.csv for
// `tandem probe SCENE.glb --path PATH.csv --tool part:NAME`.

#include <string>
#include <vector>

#include "tests/support/part_cases.h"

namespace tandem::test {

/// Positions are floats, as in any glTF file: of a part of 40 mm they are off by up to 2 nm.
std::vector<unsigned char> glbOf(const PartCase& given);

/// A row a millisecond.
std::string csvOf(const PartCase& given);

}  // namespace tandem::test
