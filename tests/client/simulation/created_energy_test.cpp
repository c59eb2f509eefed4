#include "client/simulation/created_energy.h"

#include <gtest/gtest.h>

#include <array>

namespace tandem::client {
namespace {

void add(CreatedEnergy& energy, double a, double b) { energy.add(std::array{a, b}); }

TEST(CreatedEnergy, IsTheMostEverGivenToEachHandThatIsAlone) {
  CreatedEnergy energy(2);
  add(energy, 0.002, -1.0);
  add(energy, -0.5, -1.0);
  EXPECT_EQ(energy.byHand()[0], 0.002) << "another hand pays for nothing of it";
  EXPECT_EQ(energy.byHand()[1], 0.0);
}

TEST(CreatedEnergy, WhatOneCoupledHandPutsInTheOtherMayBeGiven) {
  CreatedEnergy energy(2);
  energy.couple(1, 0);
  add(energy, 0.3, -0.3);
  EXPECT_EQ(energy.byHand()[0] + energy.byHand()[1], 0.0);
  add(energy, 0.3, -0.25);
  EXPECT_NEAR(energy.byHand()[0], 0.05, 1e-12);
  EXPECT_EQ(energy.byHand()[1], 0.0) << "it was given nothing";
}

TEST(CreatedEnergy, SumsToWhatTheHandsTogetherWereGiven) {
  CreatedEnergy energy(2);
  energy.couple(0, 1);
  add(energy, 0.03, 0.01);
  add(energy, -1.0, 0.02);
  EXPECT_NEAR(energy.byHand()[0], 0.03, 1e-12);
  EXPECT_NEAR(energy.byHand()[1], 0.01, 1e-12);
}

}  // namespace
}  // namespace tandem::client
