#pragma once

// Broken invariants inside a tick. Aborting would leave the last force on a hand, so a tick latches the
// first fault, ramps its force to zero and stays there until TickState::resetFault(). On in every build.
//
// TICK_ASSERT is for a stage that goes on around what is broken. A failed ASSERT (assets/base/assert.h)
// ends all stages of its tick, which then latches it: see assets/base/assertion_scope.h.

namespace tandem::haptics {

/// The first broken invariant since the last reset; `condition` is null while there is none.
struct FaultLatch {
  const char* condition = nullptr;
  const char* file = nullptr;
  int line = 0;

  bool raised() const { return condition != nullptr; }
  void raise(const char* what, const char* where, int atLine) {
    if (raised()) return;  // the first one is the cause, the rest are consequences
    condition = what;
    file = where;
    line = atLine;
  }
};

}  // namespace tandem::haptics

/// Evaluates to the condition, so that the caller can also step around what would go wrong next.
#define TICK_ASSERT(latch, condition) \
  (static_cast<bool>(condition) || ((latch).raise(#condition, __FILE__, __LINE__), false))
