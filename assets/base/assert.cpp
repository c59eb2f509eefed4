#include "assets/base/assert.h"

#include <cstdio>
#include <cstdlib>
#include <utility>

#include "assets/base/assertion_scope.h"

namespace tandem {
namespace {

thread_local bool throws = false;  // whether an AssertionScope is open in this thread

}  // namespace

AssertionScope::AssertionScope() : outer_(std::exchange(throws, true)) {}
AssertionScope::~AssertionScope() { throws = outer_; }

void assertFailed(const char* condition, const char* file, int line) {
  if (throws) throw FailedAssertion{condition, file, line};
  std::fprintf(stderr, "%s:%d: broken invariant: %s\n", file, line, condition);
  std::abort();
}

}  // namespace tandem
