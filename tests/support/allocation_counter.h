#pragma once

// Heap allocations of a piece of code: link tandem_allocation_counter to the test or bench that wants
// to know.

#include <cstdint>

#include "assets/base/allocation_counter.h"

namespace tandem::test {

/// Allocations between construction and count().
class AllocationScope {
 public:
  AllocationScope() : start_(allocationCount()) {}
  std::uint64_t count() const { return allocationCount() - start_; }

 private:
  std::uint64_t start_;
};

}  // namespace tandem::test
