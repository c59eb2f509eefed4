#pragma once

// The sizes that a test runs at.

#include <cstdlib>

namespace tandem::test {

/// True with TANDEM_FULL_SIZE: full meshes, more seeds, printed figures.
inline bool atFullSize() { return std::getenv("TANDEM_FULL_SIZE") != nullptr; }

}  // namespace tandem::test
