#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "haptics/body/virtual_coupling.h"
#include "haptics/geometry/plane_projection.h"
#include "haptics/operator/simulated_hand.h"
#include "haptics/safety/passivity.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::test {
namespace {

using haptics::EnergyObserver;
using haptics::HalfSpace;

TEST(EnergyObserver, ReportsTheMostThatWasEverGivenBeyondWhatCameIn) {
  EnergyObserver observer;
  observer.add(glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(-2.0, 0.0, 0.0), 0.5);  // 1 J in
  EXPECT_DOUBLE_EQ(observer.given(), -1.0);
  EXPECT_EQ(observer.mostCreated(), 0.0);
  observer.addWork({3.0, 0.0, 0.0}, {1.0, 0.0, 0.0});  // 3 J out
  observer.addWork({3.0, 0.0, 0.0}, {-1.0, 0.0, 0.0});
  EXPECT_DOUBLE_EQ(observer.mostCreated(), 2.0);
  EXPECT_DOUBLE_EQ(observer.given(), -1.0);
  observer.reset();
  observer.add(Wrench{glm::dvec3(0.0), {0.0, 2.0, 0.0}}, Twist{glm::dvec3(0.0), {0.0, 3.0, 0.0}}, 0.1);
  EXPECT_DOUBLE_EQ(observer.mostCreated(), 0.6);
}

TEST(StiffestStable, IsTheLesserOfQuantisedHoldAndDelay) {
  EXPECT_DOUBLE_EQ(haptics::stiffestStable(0.1, 1e-3, 0.0, 1e9), 200.0);
  EXPECT_DOUBLE_EQ(haptics::stiffestStable(1.0, 1e-3, 1.5e-3, 2.0), 1500.0);
  EXPECT_EQ(haptics::stiffestStable(0.0, 1e-3, 1e-3, 0.0), 0.0);
}

TEST(StiffestContact, OfADeviceFollowsItsDampingAndRate) {
  haptics::DeviceLimits device;
  device.maxForce = 3.3;
  device.damping = 0.1;
  EXPECT_DOUBLE_EQ(haptics::stiffestContact(device, 1e-3, 0.0), 200.0);
  EXPECT_NEAR(haptics::stiffestContact(device, 1e-3, 1.5e-3), 50.0, 1e-9);
  device.rate = 250.0;
  EXPECT_DOUBLE_EQ(haptics::stiffestContact(device, 1e-3, 0.0), 50.0);
  device.damping = 0.0;
  EXPECT_EQ(haptics::stiffestContact(device, 1e-3, 0.0), 0.0);
  device.damping = 0.1, device.maxForce = 0.0;
  EXPECT_EQ(haptics::stiffestContact(device, 1e-3, 0.0), 0.0);
}

TEST(PlaneProjection, AgreesWithAlternatingProjectionsOnRandomPlanes) {
  std::mt19937 random(6);
  std::normal_distribution<double> n;
  for (int round = 0; round < 300; ++round) {
    std::vector<HalfSpace> planes;
    for (int i = 0; i < 1 + round % 5; ++i) {
      // Offsets of at most zero: the origin obeys all, so that a solution exists.
      planes.push_back(
          {glm::normalize(glm::dvec3(n(random), n(random), n(random))), -0.1 * std::abs(n(random))});
    }
    const glm::dvec3 goal(n(random), n(random), n(random));
    const haptics::Projection found = haptics::projectOntoPlanes(goal, planes, 1e-12);
    ASSERT_TRUE(found.exact);
    // Dykstra's algorithm converges to the same point.
    glm::dvec3 x = goal;
    std::vector<glm::dvec3> correction(planes.size(), glm::dvec3(0.0));
    for (int sweep = 0; sweep < 20'000; ++sweep) {
      for (std::size_t i = 0; i < planes.size(); ++i) {
        const glm::dvec3 y = x + correction[i];
        const double depth = std::max(0.0, planes[i].offset - glm::dot(planes[i].normal, y));
        x = y + depth * planes[i].normal;
        correction[i] = y - x;
      }
    }
    EXPECT_LT(glm::length(found.point - x), 1e-6) << round;
    glm::dvec3 sum = goal;
    for (std::size_t i = 0; i < planes.size(); ++i) sum += found.multiplier[i] * planes[i].normal;
    EXPECT_LT(glm::length(sum - found.point), 1e-9);
  }
}

TEST(PlaneProjection, DoesNotDependOnTheOrderOfPlanes) {
  std::vector<HalfSpace> planes;
  for (int i = 0; i < 6; ++i) {
    const double a = 2.0 * kPi * i / 6.0;
    planes.push_back({glm::normalize(glm::dvec3(std::cos(a), std::sin(a), 1.0)), 0.0});
  }
  const glm::dvec3 goal(0.1, -0.2, -1.0);
  const glm::dvec3 first = haptics::projectOntoPlanes(goal, planes, 1e-12).point;
  for (int i = 0; i < 6; ++i) {
    std::rotate(planes.begin(), planes.begin() + 1, planes.end());
    EXPECT_LT(glm::length(haptics::projectOntoPlanes(goal, planes, 1e-12).point - first), 1e-12);
  }
}

TEST(PlaneProjection, SaysSoWhenPlanesContradict) {
  const std::vector<HalfSpace> planes{{{0.0, 0.0, 1.0}, 1.0}, {{0.0, 0.0, -1.0}, 1.0}};
  EXPECT_FALSE(haptics::projectOntoPlanes(glm::dvec3(0.0), planes, 1e-9).exact);
}

/// A hand presses a device onto a floor of stiffness k for eight seconds. Returns the peak-to-peak of the
/// device's height in the last second, m.
double restlessness(double stiffness, double deviceDamping) {
  SceneBuilder b;
  b.addPart(sheetMesh(0.4, 4));
  HandProbe probe(b.scene, springOnly(stiffness));
  haptics::ArmParameters arm;
  arm.gripStiffness = 40.0;  // a light grip: hardly any damping but the device's own
  arm.gripDamping = 0.05;
  haptics::SimulatedDeviceParameters device;
  device.damping = deviceDamping;
  device.friction = 0.0;
  device.quantum = 0.0;
  device.forceMax = 1e9;
  Pose start;
  start.position.z = 0.005;
  haptics::SimulatedHand hand(arm, device, start);
  haptics::HandTarget target;
  target.worldFromTarget.position.z = -0.01;
  double low = 1e9, high = -1e9;
  for (int i = 0; i < 8000; ++i) {
    probe.sample = hand.sample(1e-3 * i);
    probe.tick();
    hand.step(target, probe.out.hands[0].toHand.force, 1e-3);
    const double z = hand.devicePose().position.z;
    if (!(std::abs(z) < 1e3)) return 1e9;
    if (i < 7000) continue;  // the arm itself takes seconds to come to rest
    low = std::min(low, z);
    high = std::max(high, z);
  }
  return high - low;
}

TEST(ClosedLoop, RestsQuietlyBelowTheStiffestStable) {
  for (const double damping : {0.2, 0.5, 1.0}) {
    EXPECT_LT(restlessness(0.8 * haptics::stiffestStable(damping, 1e-3, 0.5e-3, 0.0), damping), 1e-5)
        << damping;
  }
}

TEST(ClosedLoop, BouncesFarAboveTheStiffestStable) {
  for (const double damping : {0.2, 0.5, 1.0}) {
    EXPECT_GT(restlessness(6.0 * haptics::stiffestStable(damping, 1e-3, 0.5e-3, 0.0), damping), 1e-4)
        << damping;
  }
}

}  // namespace
}  // namespace tandem::test
