#include "assets/base/assertion_scope.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "assets/base/assert.h"

namespace tandem {
namespace {

void require(bool condition) { ASSERT(condition); }

bool throwsHere() {
  try {
    require(false);
    return false;
  } catch (const FailedAssertion& broken) {
    return std::string(broken.condition) == "condition" && broken.line > 0 &&
           std::string(broken.file).find("assertion_scope_test.cpp") != std::string::npos;
  }
}

TEST(AssertionScope, ThrowsThePlaceInsideAndAbortsOutside) {
  {
    const AssertionScope scope;
    require(true);
    EXPECT_TRUE(throwsHere());
  }
  EXPECT_DEATH(require(false), "assertion_scope_test.cpp:[0-9]+: broken invariant: condition");
}

TEST(AssertionScope, Nests) {
  const AssertionScope outer;
  { const AssertionScope inner; }
  EXPECT_TRUE(throwsHere());
}

TEST(AssertionScope, HoldsForItsThreadOnly) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const AssertionScope scope;
  EXPECT_DEATH(std::thread([] { require(false); }).join(), "broken invariant");
}

}  // namespace
}  // namespace tandem
