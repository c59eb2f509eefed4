#pragma once

// Counts the heap allocations of a program. allocation_counter.cpp replaces every form of operator new in the
// program that links it.

#include <cstdint>

namespace tandem {

/// Number of calls of operator new so far, by all threads.
std::uint64_t allocationCount();

/// Number of calls of operator new by this thread since it began.
std::uint64_t allocationsOfThisThread();

}  // namespace tandem
