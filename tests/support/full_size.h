#pragma once

// The sizes that a test runs at.

#include <cstdlib>
#include <string>

namespace tandem::test {

/// True with TANDEM_FULL_SIZE: full meshes, more seeds, printed figures.
inline bool atFullSize() { return std::getenv("TANDEM_FULL_SIZE") != nullptr; }

/// A number of the environment, such as TANDEM_SEEDS; `otherwise` where it is not set.
inline unsigned numberOf(const char* name, unsigned otherwise) {
  const char* const text = std::getenv(name);
  return text != nullptr ? static_cast<unsigned>(std::stoul(text)) : otherwise;
}

}  // namespace tandem::test
