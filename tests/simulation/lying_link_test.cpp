// A site whose link packets push as no hand does is named by the site whose hand it pushes. That all others
// are told then: lying_site_test.cpp.

#include <gtest/gtest.h>

#include "tests/simulation/shared_sessions.h"

namespace tandem::test {
namespace {

client::SimulationResult pulled(client::Mistake mistake) {
  SharedSession session("shared_pull");
  session.options.mistake = mistake;
  session.options.leaderLoad = false;
  return session.run();
}

TEST(LyingLink, IsNamedByWhomItPushes) {
  const client::SimulationResult result = pulled(client::Mistake::linksLie);
  ASSERT_FALSE(result.violations.empty());
  for (const client::Violation& violation : result.violations) {
    EXPECT_EQ(violation.rule, "R5") << violation.what;
    EXPECT_EQ(violation.what.rfind("a doubts the motion of", 0), 0u) << violation.what;
  }
}

TEST(HonestLink, IsNotNamed) {
  const client::SimulationResult result = pulled(client::Mistake::none);
  EXPECT_TRUE(result.violations.empty()) << describe(result);
}

}  // namespace
}  // namespace tandem::test
