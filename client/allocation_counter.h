#pragma once

#include <cstdint>

namespace tandem::client {

/// Heap allocations by this thread since it began: the program's operator new counts them.
std::uint64_t allocationsOfThisThread();

}  // namespace tandem::client
