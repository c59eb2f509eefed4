#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "haptics/solver/step_space.h"
#include "tests/haptics/solver/solver_numbers.h"

namespace tandem::test {
namespace {

using haptics::BodyVectors;
using haptics::Displacement;
using haptics::RowDirection;
using haptics::RowPair;
using haptics::StepGoal;
using haptics::StepSpace;

BodyVectors randomVectors(Numbers& number) {
  BodyVectors y{};
  for (haptics::Vector6& of : y) {
    for (double& x : of) x = 1e-3 * number();
  }
  return y;
}

TEST(StepSpace, ZeroIsTheFreeDisplacement) {
  Numbers number(1);
  const std::array<StepGoal, 2> goals = {randomGoal(number), randomGoal(number)};
  const RowPair pair{0, 1, {0.01, 0.02, 0.03}};
  StepSpace space;
  space.begin(goals, {&pair, 1});
  space.moveTo(BodyVectors{});
  EXPECT_EQ(space.displacement(1).linear, goals[1].free.linear);
  EXPECT_EQ(space.pairMotions()[0].linear, space.freeMotion(pair).linear);
  EXPECT_EQ(space.pairMotions()[0].angular, goals[0].free.angular - goals[1].free.angular);
}

// d . y = J (u - u0) is what makes a direction stand for its row.
TEST(StepSpace, DirectionTimesPointIsForceTimesRelativeDisplacement) {
  Numbers number(2);
  for (int run = 0; run < 100; ++run) {
    const std::array<StepGoal, 2> goals = {randomGoal(number), randomGoal(number)};
    const RowPair pair{0, run % 2 == 0 ? 1 : -1, 0.02 * number.vector()};
    StepSpace space;
    space.begin(goals, {&pair, 1});
    const BodyVectors y = randomVectors(number);
    space.moveTo(y);
    const glm::dvec3 force = number.vector(), moment = 0.02 * number.vector();
    const Displacement free = space.freeMotion(pair), now = space.pairMotions()[0];
    const double work =
        glm::dot(force, now.linear - free.linear) + glm::dot(moment, now.angular - free.angular);
    EXPECT_NEAR(space.direction(pair, force, moment).dot(y), work, 1e-12 + 1e-9 * std::abs(work));
  }
}

TEST(StepSpace, DirectionsOfDifferentBodiesAreOrthogonalAndAddUpOnTheirOwn) {
  Numbers number(3);
  const std::array<StepGoal, 2> goals = {randomGoal(number), randomGoal(number)};
  const std::array<RowPair, 2> pairs = {RowPair{0, -1, {}}, RowPair{1, -1, {}}};
  StepSpace space;
  space.begin(goals, pairs);
  const RowDirection a = space.direction(pairs[0], number.vector(), number.vector());
  const RowDirection b = space.direction(pairs[1], number.vector(), number.vector());
  EXPECT_EQ(a.dot(b), 0.0);
  BodyVectors sum{};
  a.addTo(sum, 2.0);
  EXPECT_DOUBLE_EQ(a.dot(sum), 2.0 * a.dot(a));
  EXPECT_EQ(b.dot(sum), 0.0);
}

}  // namespace
}  // namespace tandem::test
