// A site whose link packets push as no hand does is named by the site whose hand it pushes. That all others
// are told then: lying_site_test.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include <glm/geometric.hpp>

#include "tests/simulation/shared_sessions.h"
#include "tests/support/full_size.h"

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

/// The largest change in 20 ms, N, of the first hand's force. Another's part presses on its own until 11 s.
double feltThroughNearParts(client::Mistake mistake, const client::LinkLie& lie = {}) {
  SharedSession session("pressed_together");
  session.setDelay(50.0);
  session.options.mistake = mistake;
  session.options.lie = lie;
  session.options.leaderLoad = false;
  std::vector<glm::dvec3> forces;
  double largest = 0.0;
  session.options.watch = [&](double, std::span<const client::SimulatedSiteState> sites) {
    forces.push_back(sites[0].force);
    largest = std::max(largest, changeIn20ms(forces, forces.size() - 1));
  };
  static_cast<void>(session.run());
  return largest;
}

/// Along and across the contact, one way or to and fro, before the parts meet or while they press.
std::vector<client::LinkLie> lies() {
  if (!atFullSize()) return {{{0.0, 1.0, 0.0}, 5.0, 0.0}, {{0.0, 1.0, 0.0}, 5.0, 2.0}};
  std::vector<client::LinkLie> all;
  for (const double from : {0.0, 5.0}) {
    for (const glm::dvec3& along : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, -1, 0)})
      all.push_back({along, from, 0.0});
    for (const double hertz : {1.0, 2.0, 5.0, 20.0, 60.0}) all.push_back({{0.0, 1.0, 0.0}, from, hertz});
  }
  return all;
}

// Contact itself makes 0.45 N. What a lie adds comes through the part that it moves.
TEST(LyingLink, IsHardlyFeltThroughPartsThatAreOnlyNear) {
  const double honest = feltThroughNearParts(client::Mistake::none);
  double most = 0.0;
  for (const client::LinkLie& lie : lies()) {
    const double felt = feltThroughNearParts(client::Mistake::linksLie, lie);
    if (atFullSize())
      std::printf("from %.0f s, along %.0f %.0f %.0f, %.0f times a second: %.2f N in 20 ms\n", lie.from,
                  lie.along.x, lie.along.y, lie.along.z, lie.hertz, felt);
    most = std::max(most, felt);
  }
  std::printf("felt through near parts: %.2f N in 20 ms, of honest packets %.2f\n", most, honest);
  EXPECT_LE(most, 0.7);
  EXPECT_LE(honest, 0.5);
}

TEST(LyingLink, IsFeltThroughNearPartsWhereItIsBelieved) {
  EXPECT_GT(feltThroughNearParts(client::Mistake::linksLieBelieved, {{0.0, 1.0, 0.0}, 5.0, 2.0}), 3.0);
}

}  // namespace
}  // namespace tandem::test
