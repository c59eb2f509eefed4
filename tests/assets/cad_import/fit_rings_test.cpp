#include "assets/cad_import/fit_rings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/gtc/matrix_transform.hpp>

#include <gtest/gtest.h>

namespace tandem::cad_import {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

Ring ring(std::uint32_t body, bool hollow, double radius = 10.0) {
  Ring ring;
  ring.body = body;
  ring.hollow = hollow;
  ring.radius = radius;
  ring.to = 20.0;
  ring.corners = {0.0};
  return ring;
}

glm::dmat4 turned(double angle) { return glm::rotate(glm::dmat4(1.0), angle, glm::dvec3(0.0, 0.0, 1.0)); }

/// The most by which an angle of `a`, turned, is off the nearest of `b`.
double apart(const std::vector<double>& a, double turn, double sign, const std::vector<double>& b) {
  double most = 0.0;
  for (const double angle : a) {
    double least = kTurn;
    for (const double other : b)
      least = std::min(least, std::abs(std::remainder(sign * angle + turn - other, kTurn)));
    most = std::max(most, least);
  }
  return most;
}

double widest(const std::vector<double>& angles) {
  double most = angles.front() + kTurn - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) most = std::max(most, angles[i] - angles[i - 1]);
  return most;
}

TEST(FitRings, ShaftTurnedInItsBoreHasTheBoresAngles) {
  const std::vector<Ring> rings{ring(0, true), ring(1, false)};
  const RingAngles chosen = chooseAngles(rings, {{0, glm::dmat4(1.0)}, {1, turned(0.123)}});
  EXPECT_EQ(chosen.fits, 1u);
  EXPECT_LT(apart(chosen.angles[1], 0.123, 1.0, chosen.angles[0]), 1e-9);
  EXPECT_EQ(chosen.angles[0].size(), chosen.angles[1].size());
  EXPECT_LE(widest(chosen.angles[0]), 0.2 + 1e-9);
}

TEST(FitRings, ShaftPutInFromTheOtherSideHasTheBoresAnglesToo) {
  const glm::dmat4 flipped =
      turned(0.3) * glm::rotate(glm::dmat4(1.0), std::numbers::pi, glm::dvec3(1.0, 0.0, 0.0));
  std::vector<Ring> rings{ring(0, true), ring(1, false)};
  rings[0].from = -20.0;
  rings[1].corners = {0.0, 0.7};
  const RingAngles chosen = chooseAngles(rings, {{0, glm::dmat4(1.0)}, {1, flipped}});
  EXPECT_EQ(chosen.fits, 1u);
  EXPECT_LT(apart(chosen.angles[1], 0.3, -1.0, chosen.angles[0]), 1e-9);
}

TEST(FitRings, OneShapeInSeveralPlacesHasAnglesThatSuitAll) {
  const std::vector<Ring> rings{ring(0, true), ring(1, false)};
  const glm::dmat4 aside = glm::translate(glm::dmat4(1.0), glm::dvec3(100.0, 0.0, 0.0));
  const std::vector<Placement> placements{
      {0, glm::dmat4(1.0)}, {1, turned(0.5)}, {0, aside}, {1, aside * turned(0.5 + kTurn / 5.0)}};
  const RingAngles chosen = chooseAngles(rings, placements);
  EXPECT_EQ(chosen.fits, 2u);
  for (const double turn : {0.5, 0.5 + kTurn / 5.0})
    EXPECT_LT(apart(chosen.angles[1], turn, 1.0, chosen.angles[0]), 1e-6);
}

TEST(FitRings, PlacesThatNoAnglesSuitAreCounted) {
  const std::vector<Ring> rings{ring(0, true), ring(1, false)};
  const glm::dmat4 aside = glm::translate(glm::dmat4(1.0), glm::dvec3(100.0, 0.0, 0.0));
  const RingAngles chosen = chooseAngles(
      rings,
      {{0, glm::dmat4(1.0)}, {1, turned(0.0)}, {0, aside}, {1, aside * turned(0.001 * std::numbers::e)}});
  EXPECT_EQ(chosen.fits, 0u);
  EXPECT_EQ(chosen.unlike, 2u);
}

TEST(FitRings, LooseOrDistantCylindersAreNoFit) {
  const std::vector<Ring> rings{ring(0, true, 10.5), ring(1, false)};
  EXPECT_EQ(chooseAngles(rings, {{0, glm::dmat4(1.0)}, {1, turned(0.1)}}).fits, 0u);
  const glm::dmat4 above = glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 0.0, 30.0));
  const std::vector<Ring> tight{ring(0, true), ring(1, false)};
  EXPECT_EQ(chooseAngles(tight, {{0, glm::dmat4(1.0)}, {1, above}}).fits, 0u);
}

}  // namespace
}  // namespace tandem::cad_import
