#pragma once

// Counts the heap allocations of a program: whoever compiles allocation_counter.cpp into it gets every form
// of operator new replaced by one that counts.

#include <cstdint>

namespace tandem {

/// Calls of operator new so far, by all threads.
std::uint64_t allocationCount();

/// Calls of operator new by this thread since it began.
std::uint64_t allocationsOfThisThread();

}  // namespace tandem
