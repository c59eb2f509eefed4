#pragma once

// Counts heap allocations of this program: compile allocation_counter.cpp into the test or bench that wants
// to know.

#include <cstdint>

namespace tandem::test {

/// Calls of operator new so far, by all threads.
std::uint64_t allocationCount();

/// Allocations between construction and count().
class AllocationScope {
 public:
  AllocationScope() : start_(allocationCount()) {}
  std::uint64_t count() const { return allocationCount() - start_; }

 private:
  std::uint64_t start_;
};

}  // namespace tandem::test
