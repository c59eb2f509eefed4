#pragma once

// Programmer's errors. ASSERT is on in every build: a broken invariant ends the program with its place, or
// throws inside an AssertionScope (assertion_scope.h), so that a tick latches a fault and lets go of the
// hand.

namespace tandem {

/// Throws inside an AssertionScope; otherwise prints the place and the condition on stderr and aborts.
[[noreturn]] void assertFailed(const char* condition, const char* file, int line);

}  // namespace tandem

#define ASSERT(condition) \
  (static_cast<bool>(condition) ? void(0) : ::tandem::assertFailed(#condition, __FILE__, __LINE__))
