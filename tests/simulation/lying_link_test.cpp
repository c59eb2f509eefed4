// A site whose link packets push as no hand does is named by the site whose hand it pushes. That all others
// are told then: lying_site_test.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include <glm/geometric.hpp>

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

/// The largest change in 20 ms, N, of the first hand's force, whose part another's presses on.
double feltThroughNearParts(client::Mistake mistake) {
  SharedSession session("pressed_together");
  session.setDelay(50.0);
  session.options.mistake = mistake;
  session.options.leaderLoad = false;
  std::vector<glm::dvec3> forces;
  double largest = 0.0;
  session.options.watch = [&](double, std::span<const client::SimulatedSiteState> sites) {
    forces.push_back(sites[0].force);
    const std::size_t before = forces.size() - 1 - std::min<std::size_t>(20, forces.size() - 1);
    largest = std::max(largest, glm::length(forces.back() - forces[before]));
  };
  static_cast<void>(session.run());
  return largest;
}

// Links of parts that are only near a held one are believed (haptics/link/README.md, Limits): one that says
// 30 N is felt more than twice as much as contact is.
TEST(LyingLink, IsFeltThroughPartsThatAreOnlyNear) {
  const double lied = feltThroughNearParts(client::Mistake::linksLie);
  const double honest = feltThroughNearParts(client::Mistake::none);
  std::printf("felt through near parts: %.2f N in 20 ms, of honest packets %.2f\n", lied, honest);
  EXPECT_LE(lied, 1.3);
  EXPECT_LE(honest, 0.5);
}

}  // namespace
}  // namespace tandem::test
