#pragma once

// Broken invariants in a loop that drives an actuator, where a program that ends would leave its last force
// on a hand.
//
// Inside an AssertionScope a failed ASSERT throws a FailedAssertion instead of aborting. Control leaves the
// code whose invariant is broken, so nothing after the check runs with a bad index or a null pointer. Whoever
// opens the scope catches. While invariants hold the scope costs two writes of a thread-local flag; a failure
// takes the memory of one exception from the C++ runtime.

namespace tandem {

/// Thrown by a failed ASSERT inside an AssertionScope. Not a std::exception, so that no handler of operating
/// errors takes it.
struct FailedAssertion {
  const char* condition = nullptr;
  const char* file = nullptr;
  int line = 0;
};

/// Holds for the thread that makes it, while it lives. Scopes nest.
class AssertionScope {
 public:
  AssertionScope();
  ~AssertionScope();
  AssertionScope(const AssertionScope&) = delete;
  AssertionScope& operator=(const AssertionScope&) = delete;

 private:
  bool outer_;  // whether another scope was open already
};

}  // namespace tandem
