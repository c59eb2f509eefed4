#include "haptics/grasp/hand.h"

#include <gtest/gtest.h>

namespace tandem::haptics {
namespace {

constexpr double kHandCoupling = 800.0;  // N/m

HandInput inputAt(double z) {
  HandInput input;
  input.device.worldFromDevice.position.z = z;
  input.device.valid = true;
  return input;
}

TickParameters limitedTo(double force) {
  TickParameters p;
  p.forceLimit = force;
  return p;
}

/// Force of a fade that began with 1 N along z in a tick in which the hand moved by 1 mm along it, at the
/// end of that tick.
double fadedInItsFirstTick(bool hasTool) {
  Hand hand(hasTool);
  FaultLatch fault;
  hand.begin(inputAt(0.0), limitedTo(3.0));
  hand.begin(inputAt(1e-3), limitedTo(3.0));
  hand.fadeOut({{0.0, 0.0, 1.0}, {}}, {kHandCoupling, 0.0});
  hand.send(nullptr, {}, fault);
  return hand.fade().now().force.z;
}

TEST(Hand, ClipsAnEndingForceToItsDeviceOnlyIfItsToolIsPartOfTheTick) {
  for (const bool hasTool : {true, false}) {
    Hand hand(hasTool);
    hand.begin(inputAt(0.0), limitedTo(1.0));
    hand.fadeOut({{0.0, 0.0, 5.0}, {}}, {kHandCoupling, 0.0});
    EXPECT_DOUBLE_EQ(hand.fade().now().force.z, hasTool ? 1.0 : 5.0);
  }
}

TEST(Hand, FadesAtOnceWithItsDisplacementOnlyIfItsToolIsPartOfTheTick) {
  EXPECT_EQ(fadedInItsFirstTick(true), 0.0);  // 1 mJ is more than the spring stored
  EXPECT_NEAR(fadedInItsFirstTick(false), 1.0 - 1.0 / 300.0, 1e-12);
}

TEST(Hand, IsElsewhereIfItMovedDuringAStall) {
  for (const double moved : {0.5e-3, 2e-3}) {
    Hand hand(true);
    hand.begin(inputAt(0.0), {});
    hand.noteStall();
    hand.begin(inputAt(moved), {});
    EXPECT_EQ(hand.elsewhere(), moved > 1e-3);
    hand.begin(inputAt(2.0 * moved), {});
    EXPECT_FALSE(hand.elsewhere());
  }
}

TEST(Hand, HasNoVelocityAtRestBesidesItsReading) {
  Hand hand(false);
  HandInput input = inputAt(0.0);
  input.device.twist.linear.x = 0.05;
  for (int i = 0; i < 100; ++i) hand.begin(input, {});
  EXPECT_EQ(hand.steadyDevice().twist.linear.x, 0.0);
  EXPECT_EQ(hand.device().twist.linear.x, 0.05);
}

TEST(Hand, PullsAtNothingAndGetsNoForceWithoutAReading) {
  Hand hand(false);
  FaultLatch fault;
  HandInput input = inputAt(0.0);
  input.tool.force.z = 1.0;
  TickParameters p = limitedTo(3.0);
  p.slewLimit = 1e9;
  hand.begin(input, p);
  EXPECT_EQ(hand.tool(true), nullptr);
  ASSERT_NE(hand.tool(false), nullptr);
  EXPECT_EQ(hand.send(hand.tool(false), {}, fault).force.z, 1.0);
  input.device.valid = false;
  hand.begin(input, p);
  hand.setCoupling({{0.0, 0.0, 2.0}, {}});
  EXPECT_EQ(hand.tool(false), nullptr);
  EXPECT_EQ(hand.pull().device, nullptr);
  EXPECT_EQ(hand.send(hand.tool(false), {}, fault).force, glm::dvec3(0.0));
  EXPECT_EQ(hand.flags(), static_cast<std::uint32_t>(kFlagInvalidSample));
  EXPECT_EQ(hand.silence(), 0.0);
  hand.begin(input, p);
  EXPECT_EQ(hand.silence(), p.dt);
  EXPECT_EQ(hand.device().worldFromDevice.position, glm::dvec3(0.0));
}

}  // namespace
}  // namespace tandem::haptics
