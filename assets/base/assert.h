#pragma once

// Programmer's errors. ASSERT is on in every build: a broken invariant ends the program with its place,
// except inside a haptic tick, which uses TICK_ASSERT (haptics/base/fault.h) to latch a fault and let go of the hand.

namespace tandem {

/// Prints the place and the condition on stderr and aborts.
[[noreturn]] void assertFailed(const char* condition, const char* file, int line);

}  // namespace tandem

#define ASSERT(condition) \
  (static_cast<bool>(condition) ? void(0) : ::tandem::assertFailed(#condition, __FILE__, __LINE__))
