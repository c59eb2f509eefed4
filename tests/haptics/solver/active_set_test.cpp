#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "haptics/solver/active_set.h"
#include "tests/haptics/solver/solver_numbers.h"

namespace tandem::test {
namespace {

using haptics::ActiveSet;
using haptics::BodyVectors;

ActiveSet::Row row(int number, const haptics::Vector6& direction, double bound) {
  ActiveSet::Row made;
  made.row = number;
  made.direction.of[0] = direction;
  made.direction.of[1] = {};
  made.bound = bound;
  return made;
}

ActiveSet startedAt(const BodyVectors& start) {
  ActiveSet set;
  set.begin(1, start);
  return set;
}

TEST(ActiveSet, ARowMovesThePointStraightOntoItsBound) {
  ActiveSet set = startedAt({});
  ActiveSet::Conflict conflict;
  ASSERT_TRUE(set.add(row(7, {2.0, 0.0, 0.0, 0.0, 0.0, 0.0}, 1.0), conflict));
  EXPECT_DOUBLE_EQ(set.point()[0][0], 0.5);
  EXPECT_EQ(set.point()[0][1], 0.0);
  ASSERT_EQ(set.rows().size(), 1u);
  EXPECT_DOUBLE_EQ(set.rows()[0].multiplier, 0.25);
}

TEST(ActiveSet, ARowThatBeginsToPullLeaves) {
  ActiveSet set = startedAt({});
  ActiveSet::Conflict conflict;
  ASSERT_TRUE(set.add(row(0, {1.0, 0.0, 0.0, 0.0, 0.0, 0.0}, 1.0), conflict));
  // The second row alone carries the point beyond the first one's bound.
  ASSERT_TRUE(set.add(row(1, {1.0, 1.0, 0.0, 0.0, 0.0, 0.0}, 4.0), conflict));
  ASSERT_EQ(set.rows().size(), 1u);
  EXPECT_EQ(set.rows()[0].row, 1);
  EXPECT_NEAR(set.point()[0][0], 2.0, 1e-12);
  EXPECT_NEAR(set.point()[0][1], 2.0, 1e-12);
}

TEST(ActiveSet, ACompliantRowBendsByItsMultiplier) {
  ActiveSet set = startedAt({});
  ActiveSet::Conflict conflict;
  ActiveSet::Row spring = row(0, {1.0, 0.0, 0.0, 0.0, 0.0, 0.0}, 1.0);
  spring.compliance = 3.0;
  ASSERT_TRUE(set.add(spring, conflict));
  EXPECT_DOUBLE_EQ(set.point()[0][0], 0.25);
  EXPECT_DOUBLE_EQ(set.point()[0][0] + 3.0 * set.rows()[0].multiplier, 1.0);
}

TEST(ActiveSet, AContradictionChangesNothingAndNamesItsRows) {
  ActiveSet set = startedAt({});
  ActiveSet::Conflict conflict;
  ASSERT_TRUE(set.add(row(3, {1.0, 0.0, 0.0, 0.0, 0.0, 0.0}, 1.0), conflict));
  ASSERT_TRUE(set.add(row(4, {0.0, 1.0, 0.0, 0.0, 0.0, 0.0}, 1.0), conflict));
  const BodyVectors before = set.point();
  const ActiveSet::Row contrary = row(5, {-1.0, 0.0, 0.0, 0.0, 0.0, 0.0}, 1.0);
  EXPECT_FALSE(set.add(contrary, conflict));
  EXPECT_EQ(set.point()[0], before[0]);
  EXPECT_EQ(set.rows().size(), 2u);
  ASSERT_EQ(conflict.size(), 2u);
  EXPECT_EQ(conflict[0], 5);
  EXPECT_EQ(conflict[1], 3);
}

TEST(ActiveSet, AnEquationMayPull) {
  ActiveSet set = startedAt({});
  ActiveSet::Conflict conflict;
  ActiveSet::Row equation = row(0, {1.0, 0.0, 0.0, 0.0, 0.0, 0.0}, 1.0);
  equation.isEquality = true;
  ASSERT_TRUE(set.add(equation, conflict));
  ASSERT_TRUE(set.add(row(1, {1.0, 1.0, 0.0, 0.0, 0.0, 0.0}, 4.0), conflict));
  ASSERT_EQ(set.rows().size(), 2u);
  EXPECT_LT(set.rows()[0].multiplier, 0.0);
  EXPECT_NEAR(set.point()[0][0], 1.0, 1e-12);
  EXPECT_NEAR(set.point()[0][1], 3.0, 1e-12);
}

TEST(ActiveSet, KeepsTheOptimalityConditionsOfRandomRows) {
  Numbers number(4);
  for (int run = 0; run < 300; ++run) {
    BodyVectors start{};
    for (double& x : start[0]) x = number();
    ActiveSet set = startedAt(start);
    std::array<ActiveSet::Row, 12> rows;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      haptics::Vector6 direction;
      for (double& x : direction) x = number();
      rows[i] = row(static_cast<int>(i), direction, -std::abs(number()));  // 0 obeys all rows
    }
    ActiveSet::Conflict conflict;
    for (int guard = 0; guard < 100; ++guard) {
      std::size_t worst = rows.size();
      double greatest = 1e-12;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const double missing = rows[i].bound - rows[i].direction.dot(set.point());
        if (missing > greatest) greatest = missing, worst = i;
      }
      if (worst == rows.size()) break;
      ASSERT_TRUE(set.add(rows[worst], conflict));
    }
    for (const ActiveSet::Row& each : rows) EXPECT_GT(each.direction.dot(set.point()), each.bound - 1e-9);
    BodyVectors sum = start;
    for (const ActiveSet::Row& active : set.rows()) {
      EXPECT_GE(active.multiplier, 0.0);
      active.direction.addTo(sum, active.multiplier);
    }
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(sum[0][k], set.point()[0][k], 1e-9);
  }
}

}  // namespace
}  // namespace tandem::test
