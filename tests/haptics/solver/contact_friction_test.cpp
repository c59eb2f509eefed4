#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/solver/contact_friction.h"

namespace tandem::test {
namespace {

using haptics::ActiveSet;
using haptics::BodyVectors;
using haptics::ContactFriction;
using haptics::ContactRows;
using haptics::ExactRow;
using haptics::FrictionForce;
using haptics::RowPair;
using haptics::StepGoal;
using haptics::StepSpace;

/// A surface that moves by `motion` in the tick.
class FlatGround final : public haptics::RowRefiner {
 public:
  void refine(haptics::RowSource, const haptics::Displacement&, ContactRows&) override {}
  glm::dvec3 surfaceMotion(const ExactRow&) const override { return motion; }
  glm::dvec3 motion{0.0, 0.0, 0.0};
};

/// A body of unit mass with one active row under it, whose multiplier is 1.
class OneContact {
 public:
  OneContact(double staticFriction, double dynamicFriction) {
    for (std::size_t i = 0; i < 6; ++i) goal.root[i][i] = 1.0;
    ExactRow row;
    row.normal = {0.0, 0.0, 1.0};
    row.staticFriction = staticFriction;
    row.dynamicFriction = dynamicFriction;
    rows.addExact(row);
  }
  /// The displacement that friction causes where the body would slip by `slip`.
  glm::dvec3 solve(const glm::dvec3& slip) {
    goal.free.linear = slip;
    StepSpace space;
    space.begin({&goal, 1}, {&pair, 1});
    ActiveSet::Rows active;
    ActiveSet::Row& normal = active.push_back({});
    normal.row = 0;
    normal.direction = space.direction(pair, {0.0, 0.0, 1.0}, glm::dvec3(0.0));
    normal.multiplier = 1.0;
    BodyVectors none{}, part{};
    change = friction.solve(space, active, rows, ground, none, part);
    return {part[0][0], part[0][1], part[0][2]};
  }

  StepGoal goal;
  RowPair pair;
  ContactRows rows;
  FlatGround ground;
  ContactFriction friction;
  ContactFriction::Change change;
};

TEST(ContactFriction, InsideTheDiscStopsTheSlip) {
  OneContact contact(0.5, 0.5);
  const glm::dvec3 slip(0.2, -0.3, 0.0);
  EXPECT_LT(glm::length(contact.solve(slip) + slip), 1e-5);
  ASSERT_EQ(contact.friction.forces().size(), 1u);
  EXPECT_TRUE(contact.friction.forces()[0].sticks);
}

TEST(ContactFriction, OutsideTheDiscIsItsBorderAgainstTheSlip) {
  OneContact contact(0.5, 0.4);
  const glm::dvec3 slip(3.0, 4.0, 0.0), part = contact.solve(slip);
  EXPECT_NEAR(glm::length(part), 0.4, 1e-9);
  EXPECT_NEAR(glm::dot(part, slip), -0.4 * 5.0, 1e-5);
  EXPECT_FALSE(contact.friction.forces()[0].sticks);
}

TEST(ContactFriction, AStickingContactHoldsBeyondTheForceOfASlidingOne) {
  OneContact contact(0.5, 0.4);
  const FrictionForce sticking{{}, {-0.45, 0.0, 0.0}, true};
  contact.friction.recall({&sticking, 1});
  EXPECT_NEAR(contact.solve({0.45, 0.0, 0.0}).x, -0.45, 1e-5);
  EXPECT_TRUE(contact.friction.forces()[0].sticks);
}

TEST(ContactFriction, FollowsTheSurfaceThatMoves) {
  OneContact contact(0.5, 0.5);
  contact.ground.motion = {0.1, 0.0, 0.0};
  EXPECT_NEAR(contact.solve(glm::dvec3(0.0)).x, 0.1, 1e-5);
}

TEST(ContactFriction, StartsFromTheForcesThatItIsGiven) {
  OneContact contact(0.5, 0.5);
  const FrictionForce known{{}, {-0.2, 0.0, 0.0}, true};
  contact.friction.recall({&known, 1});
  contact.goal.free.linear = glm::dvec3(0.2, 0.0, 0.0);
  StepSpace space;
  space.begin({&contact.goal, 1}, {&contact.pair, 1});
  BodyVectors sum{};
  contact.friction.addTo(space, contact.rows, sum);
  EXPECT_DOUBLE_EQ(sum[0][0], -0.2);
  contact.solve({0.2, 0.0, 0.0});
  EXPECT_LT(contact.change.force, 1e-5);
  EXPECT_LT(contact.change.slip, 1e-5);
}

TEST(ContactFriction, SaysHowFarAChangeMovesWhatIsLight) {
  // The same change of friction, as a share of the normal force, moves the lighter body further.
  OneContact heavy(0.5, 0.5), light(0.5, 0.5);
  for (std::size_t i = 0; i < 6; ++i) light.goal.root[i][i] = 0.01;
  heavy.solve({1e-6, 0.0, 0.0});
  light.solve({1e-2, 0.0, 0.0});
  EXPECT_NEAR(heavy.change.force, light.change.force, 1e-7);
  EXPECT_GT(light.change.slip, 1e3 * heavy.change.slip);
}

TEST(ContactFriction, WithoutCoefficientsThereIsNone) {
  OneContact contact(0.0, 0.0);
  EXPECT_EQ(contact.solve({1.0, 0.0, 0.0}), glm::dvec3(0.0));
  EXPECT_TRUE(contact.friction.forces().empty());
}

}  // namespace
}  // namespace tandem::test
