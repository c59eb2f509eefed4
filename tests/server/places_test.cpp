#include "server/places.h"

#include <gtest/gtest.h>

#include <random>

namespace tandem::server {
namespace {

using sync::Role;

/// Comes in and goes at random, as the places allow, with the rules that must hold whatever the order.
TEST(Places, WhateverTheOrderAnInstructorFindsAPlaceAndParticipantsKeepTheirs) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    const Places places{1 + random() % 8, random() % 8};
    RoleCounts there{};
    const auto in = [&](Role role) -> std::size_t& { return there[static_cast<std::size_t>(role)]; };
    for (int i = 0; i < 300; ++i) {
      const auto role = static_cast<Role>(random() % 3);
      if (random() % 3 == 0)
        in(role) -= in(role) > 0 ? 1 : 0;
      else if (!places.refusal(role, there))
        ++in(role);
      ASSERT_LE(in(Role::participant), places.participants);
      ASSERT_LE(in(Role::observer), places.observers);
      ASSERT_LE(in(Role::participant) + in(Role::instructor), places.participants + 1);
      if (in(Role::instructor) == 0) {
        ASSERT_FALSE(places.refusal(Role::instructor, there)) << seed;
      }
      if (in(Role::participant) + in(Role::instructor) < places.participants) {
        ASSERT_FALSE(places.refusal(Role::participant, there)) << seed;
      }
    }
  }
}

TEST(Places, FitTheListOfAWelcome) {
  EXPECT_TRUE(Places{}.fit());
  EXPECT_FALSE((Places{64, sync::kMaxSites - 64}.fit()));
}

}  // namespace
}  // namespace tandem::server
