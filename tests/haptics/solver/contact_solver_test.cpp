#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "haptics/solver/contact_solver.h"
#include "tests/haptics/solver/solver_numbers.h"

namespace tandem::test {
namespace {

using haptics::ContactRows;
using haptics::ContactSolver;
using haptics::Displacement;
using haptics::ExactRow;
using haptics::RowSource;
using haptics::StepGoal;
using Matrix6 = std::array<std::array<double, 6>, 6>;
using haptics::Vector6;

Vector6 flat(const Displacement& u) {
  return {u.linear.x, u.linear.y, u.linear.z, u.angular.x, u.angular.y, u.angular.z};
}

Vector6 wrench(const ExactRow& row) {
  const glm::dvec3 m = glm::cross(row.arm, row.normal);
  return {row.normal.x, row.normal.y, row.normal.z, m.x, m.y, m.z};
}

/// A (u - u0), from the factor that the goal holds.
Vector6 pull(const StepGoal& goal, const Displacement& u) {
  Vector6 d = flat(u), t{}, result{};
  const Vector6 free = flat(goal.free);
  for (std::size_t k = 0; k < 6; ++k) d[k] -= free[k];
  for (std::size_t k = 0; k < 6; ++k) {
    for (std::size_t i = k; i < 6; ++i) t[k] += goal.root[i][k] * d[i];
  }
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t k = 0; k <= i; ++k) result[i] += goal.root[i][k] * t[k];
  }
  return result;
}

/// Refines samples into rows that are known beforehand.
class KnownRows final : public haptics::RowRefiner {
 public:
  void refine(RowSource source, const Displacement&, ContactRows& rows) override {
    ++queries;
    rows.addExact(exact[source.sample]);
  }
  bool mayTouchBeside(RowSource, const glm::vec3&, float, const Displacement&) override {
    ++judged;
    return looksBeside;
  }
  glm::dvec3 surfaceMotion(const ExactRow&) const override { return ground; }

  std::vector<ExactRow> exact;
  bool looksBeside = false;
  int judged = 0;
  glm::dvec3 ground{0.0, 0.0, 0.0};
  int queries = 0;
};

constexpr double kTolerance = 1e-10;

/// One body, and one pair of it with something that does not give way.
Displacement solveOne(ContactSolver& solver, const StepGoal& goal, double tolerance, ContactRows& rows,
                      KnownRows& known) {
  const haptics::RowPair pair;
  solver.solve({&goal, 1}, {&pair, 1}, tolerance, 400, rows, known);
  return solver.displacement(0);
}

/// Feasible, every multiplier at least zero, nothing pulls but active rows.
void expectOptimal(const StepGoal& goal, const KnownRows& known, const ContactSolver& solver,
                   const ContactRows& rows, const Displacement& u) {
  for (const ExactRow& row : known.exact) EXPECT_LT(row.violation(u), 2.0 * kTolerance);
  Vector6 left = pull(goal, u);
  double size = 0.0;
  for (const double x : left) size = std::max(size, std::abs(x));
  for (const haptics::ActiveSet::Row& active : solver.active()) {
    EXPECT_GE(active.multiplier, 0.0);
    const Vector6 w = wrench(rows.exact(active.row));
    for (std::size_t k = 0; k < 6; ++k) left[k] -= active.multiplier * w[k];
  }
  // Rows that are nearly the same share their force in any proportion: to a hundred-thousandth of it.
  for (const double x : left) EXPECT_LT(std::abs(x), 1e-5 * size + 1e-18);
}

TEST(ContactSolver, GoesWhereItWouldWithoutRows) {
  Numbers number(1);
  const StepGoal goal = randomGoal(number);
  ContactRows rows;
  KnownRows known;
  ContactSolver solver;
  const Displacement u = solveOne(solver, goal, kTolerance, rows, known);
  EXPECT_EQ(u.linear, goal.free.linear);
  EXPECT_EQ(u.angular, goal.free.angular);
}

TEST(ContactSolver, FindsTheOneOptimumOfRandomRowsHoweverMuchIsKnownOfThem) {
  Numbers number(2);
  std::size_t greatest = 0;
  for (int run = 0; run < 300; ++run) {
    const StepGoal goal = randomGoal(number);
    KnownRows known;
    for (std::uint32_t i = 0; i < 40; ++i) known.exact.push_back(randomRow(number, i));
    Displacement answers[3];
    for (int kind = 0; kind < 3; ++kind) {
      ContactRows rows;
      rows.beginPair();
      for (std::uint32_t i = 0; i < known.exact.size(); ++i) {
        const ExactRow& row = known.exact[i];
        const RowSource source{0, 0, i};
        // A plane is rounded to float, and a ball has slightly less room than the gap.
        if (kind == 0) rows.addExact(row);
        if (kind == 1)
          rows.addPlane(glm::vec3(row.normal), glm::vec3(row.arm), static_cast<float>(row.gap), source);
        if (kind == 2) rows.addBall(glm::vec3(row.arm), static_cast<float>(0.999 * row.gap), source);
      }
      ContactSolver solver;
      answers[kind] = solveOne(solver, goal, kTolerance, rows, known);
      greatest = std::max(greatest, solver.active().size());
      EXPECT_EQ(solver.infeasible(), 0);
      expectOptimal(goal, known, solver, rows, answers[kind]);
    }
    for (int kind = 1; kind < 3; ++kind) {
      EXPECT_LT(glm::length(answers[kind].linear - answers[0].linear), 1e-8);
      EXPECT_LT(glm::length(answers[kind].angular - answers[0].angular), 1e-6);
    }
  }
  EXPECT_EQ(greatest, 6u);
}

TEST(ContactSolver, QueriesOnlyWhatIsViolated) {
  Numbers number(3);
  StepGoal goal = randomGoal(number);
  goal.free = {{0.0, 0.0, -1e-4}, {0.0, 0.0, 0.0}};
  KnownRows known;
  ContactRows rows;
  rows.beginPair();
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const glm::dvec3 arm(0.02 * number(), 0.02 * number(), -0.01);
    known.exact.push_back({{0.0, 0.0, 1.0}, arm, i < 3 ? 1e-5 : 1e-3, 0.0, 0.0, {0, 0, i}});
    rows.addPlane({0.0f, 0.0f, 1.0f}, glm::vec3(arm), static_cast<float>(known.exact.back().gap), {0, 0, i});
  }
  ContactSolver solver;
  solveOne(solver, goal, kTolerance, rows, known);
  EXPECT_LE(known.queries, 3);
  EXPECT_GE(known.queries, 1);
}

TEST(ContactSolver, ObeysRowsBesideThePlanesThatItObeys) {
  Numbers number(5);
  StepGoal goal = randomGoal(number);
  goal.free = {{0.0, 0.0, -1e-4}, {0.0, 0.0, 0.0}};
  for (const bool looks : {false, true}) {
    KnownRows known;
    known.looksBeside = looks;
    ContactRows rows;
    rows.beginPair();
    // The part is 50 um deeper beside the place of its plane, which is out of reach.
    known.exact.push_back({{0.0, 0.0, 1.0}, {0.0, 0.0, -0.01}, 7e-5, 0.0, 0.0, {0, 0, 0}});
    rows.addPlane({0.0f, 0.0f, 1.0f}, {0.001f, 0.0f, -0.01f}, 1.2e-4f, {0, 0, 0}, 6e-5f);
    ContactSolver solver;
    const Displacement u = solveOne(solver, goal, kTolerance, rows, known);
    EXPECT_GE(known.judged, 1);
    EXPECT_EQ(known.queries, looks ? 1 : 0);
    EXPECT_NEAR(-u.at(known.exact[0].arm).z, looks ? 7e-5 : 1e-4, 1e-9);
  }
}

/// A block of 1 kg with its centre 1 cm above the ground, on four feet.
struct Block {
  explicit Block(double friction) {
    for (std::size_t i = 0; i < 6; ++i) goal.root[i][i] = i < 3 ? 1.0 : 0.01;
    for (std::uint32_t i = 0; i < 4; ++i) {
      const glm::dvec3 arm((i & 1) != 0 ? 0.01 : -0.01, (i & 2) != 0 ? 0.01 : -0.01, -0.01);
      known.exact.push_back({{0.0, 0.0, 1.0}, arm, 0.0, friction, friction, {0, 0, i}});
    }
  }
  Displacement solve(const glm::dvec3& push) {
    goal.free = {push, {0.0, 0.0, 0.0}};
    rows.clear();
    for (const ExactRow& row : known.exact) rows.addExact(row);
    return solveOne(solver, goal, 1e-12, rows, known);
  }
  StepGoal goal;
  KnownRows known;
  ContactRows rows;
  ContactSolver solver;
};

TEST(ContactSolver, FrictionHoldsInsideTheConeAndDragsOnItsBorder) {
  Block block(0.3);
  for (const double angle : {0.0, 0.7, 2.0}) {
    const glm::dvec3 direction(std::cos(angle), std::sin(angle), 0.0);
    Displacement u = block.solve(glm::dvec3(0.0, 0.0, -1e-4) + 0.299e-4 * direction);
    EXPECT_LT(glm::length(u.linear), 1e-7);
    for (int i = 0; i < 3; ++i) u = block.solve(glm::dvec3(0.0, 0.0, -1e-4) + 0.299e-4 * direction);
    EXPECT_LT(glm::length(u.linear), 2e-8);
    for (int i = 0; i < 3; ++i) u = block.solve(glm::dvec3(0.0, 0.0, -1e-4) + 1e-4 * direction);
    EXPECT_NEAR(glm::dot(u.linear, direction), 0.7e-4, 1e-7);
    EXPECT_LT(std::abs(u.linear.z), 1e-8);
  }
}

TEST(ContactSolver, WithoutFrictionNothingHolds) {
  Block block(0.0);
  EXPECT_NEAR(block.solve({1e-5, 0.0, -1e-4}).linear.x, 1e-5, 1e-15);
}

TEST(ContactSolver, FrictionCarriesThePartAlongWithTheGround) {
  Block block(0.5);
  block.known.ground = {2e-5, 0.0, 0.0};
  Displacement u;
  for (int i = 0; i < 4; ++i) u = block.solve({0.0, 0.0, -1e-4});
  EXPECT_NEAR(u.linear.x, 2e-5, 1e-7);
}

TEST(ContactSolver, RowsThatContradictEachOtherAreCountedAndLetNothingInDeeper) {
  ContactRows rows;
  KnownRows known;
  ContactSolver solver;
  Numbers number(4);
  const StepGoal goal = randomGoal(number);
  rows.addExact({{0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, -1e-4, 0.0, 0.0, {}});
  rows.addExact({{0.0, 0.0, -1.0}, {0.0, 0.0, 0.0}, -1e-4, 0.0, 0.0, {}});
  const Displacement u = solveOne(solver, goal, kTolerance, rows, known);
  EXPECT_GT(solver.infeasible(), 0);
  EXPECT_LT(std::abs(u.linear.z), 2.0 * kTolerance);
  EXPECT_LT(glm::length(u.linear), 1e-3);
  EXPECT_LT(glm::length(u.angular), 0.1);
}

TEST(ContactSolver, ARowThatCanBeObeyedAloneIsObeyed) {
  ContactRows rows;
  KnownRows known;
  ContactSolver solver;
  Numbers number(4);
  rows.addExact({{0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, -1e-4, 0.0, 0.0, {}});
  EXPECT_NEAR(solveOne(solver, randomGoal(number), kTolerance, rows, known).linear.z, 1e-4, 2.0 * kTolerance);
  EXPECT_EQ(solver.infeasible(), 0);
}

TEST(ContactSolver, AmongRandomRowsASqueezedBodyGoesInDeeperNowhere) {
  Numbers number(6);
  for (int run = 0; run < 300; ++run) {
    const StepGoal goal = randomGoal(number);
    KnownRows known;
    for (std::uint32_t i = 0; i < 30; ++i) {
      known.exact.push_back(randomRow(number, i));
      if (i % 3 == 0) known.exact.back().gap *= -10.0;
    }
    // Two jaws nearer to each other than the body is wide, whatever it does.
    ExactRow jaw = randomRow(number, 30);
    jaw.gap = -1e-4;
    known.exact.push_back(jaw);
    jaw.normal = -jaw.normal;
    jaw.source.sample = 31;
    known.exact.push_back(jaw);
    ContactRows rows;
    rows.beginPair();
    for (const ExactRow& row : known.exact) rows.addBall(glm::vec3(row.arm), 0.0f, row.source);
    ContactSolver solver;
    const Displacement u = solveOne(solver, goal, kTolerance, rows, known);
    EXPECT_GT(solver.infeasible(), 0);
    for (ExactRow& row : known.exact) row.gap = std::max(row.gap, 0.0);
    expectOptimal(goal, known, solver, rows, u);
  }
}

TEST(ContactRows, DropsWhatDoesNotFitAndSaysSo) {
  ContactRows rows;
  for (int i = 0; i < ContactRows::kMaxExact + 5; ++i) rows.addExact({});
  EXPECT_EQ(rows.exactRows(), ContactRows::kMaxExact);
  EXPECT_EQ(rows.dropped(), 5);
  rows.clear();
  EXPECT_EQ(rows.dropped(), 0);
}

TEST(ContactRows, TheSafeShareOfAMotionStopsAtExactRowsToo) {
  ContactRows rows;
  rows.beginPair();
  ExactRow row;
  row.normal = {0.0, 0.0, 1.0};
  row.gap = 1e-5;
  rows.addExact(row);
  const auto share = [&](double z) {
    const Displacement u{{0.0, 0.0, z}, {0.0, 0.0, 0.0}};
    return rows.safeShare({&u, 1});
  };
  EXPECT_EQ(share(-1e-5), 1.0);
  EXPECT_NEAR(share(-4e-5), 0.25, 1e-12);
  // Nothing that is inside goes in deeper, and it may come out.
  row.gap = -1e-6;
  rows.addExact(row);
  EXPECT_EQ(share(-4e-5), 0.0);
  EXPECT_EQ(share(4e-5), 1.0);
}

TEST(ContactRows, TellsTheLowestPlanesBesideWhichAPartMayTouch) {
  Numbers number(6);
  for (int count : {0, 1, 7, 100, 1000}) {
    ContactRows rows;
    struct Plane {
      glm::vec3 normal, arm;
      float gap, beside;
    };
    std::vector<Plane> planes;
    const Displacement u{{1e-4, -2e-4, 3e-5}, {2e-3, 0.0, -1e-3}};
    rows.beginPair();
    for (int i = 0; i < count; ++i) {
      const glm::vec3 normal = glm::normalize(glm::vec3(number(), number(), number()) + 0.01f),
                      arm = 0.02f * glm::vec3(number(), number(), number());
      planes.push_back({normal, arm, 1e-3f * static_cast<float>(number() + 1.0), i % 3 == 0 ? 1e-3f : 0.0f});
      rows.addPlane(normal, arm, planes.back().gap, {0, 0, static_cast<std::uint32_t>(i)},
                    planes.back().beside);
    }
    std::vector<float> left;
    for (const Plane& p : planes) {
      const double moved = glm::dot(glm::dvec3(p.normal), u.at(glm::dvec3(p.arm)));
      const float room = p.gap + static_cast<float>(moved);
      if (room < p.beside) left.push_back(room);
    }
    std::sort(left.begin(), left.end());
    ContactRows::LowPlanes found;
    rows.lowestBeside({&u, 1}, found);
    ASSERT_EQ(found.size(), std::min(left.size(), ContactRows::kMaxBeside)) << count;
    for (std::size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k].room, left[k], 1e-9) << count;
  }
}

TEST(ContactRows, TellsTheWorstOfAnyNumberOfPlanes) {
  Numbers number(5);
  for (const int count : {1, 2, 3, 4, 5, 7, 8, 30, 31}) {
    ContactRows rows;
    rows.beginPair();
    std::vector<ExactRow> list;
    for (int i = 0; i < count; ++i) {
      list.push_back(randomRow(number, static_cast<std::uint32_t>(i)));
      rows.addPlane(glm::vec3(list.back().normal), glm::vec3(list.back().arm),
                    static_cast<float>(list.back().gap), {});
    }
    const Displacement u{1e-3 * number.vector(), 1e-2 * number.vector()};
    int worst = -1;
    double greatest = 0.0;
    for (int i = 0; i < count; ++i) {
      const double violation = list[static_cast<std::size_t>(i)].violation(u);
      if (violation > greatest) greatest = violation, worst = i;
    }
    EXPECT_EQ(rows.worstPlane({&u, 1}, 0.0), worst) << count;
    EXPECT_EQ(rows.worstPlane({&u, 1}, 2.0 * greatest + 1e-3), -1) << count;
  }
}

}  // namespace
}  // namespace tandem::test
