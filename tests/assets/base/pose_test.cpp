#include "assets/base/pose.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace tandem {
namespace {

double distance(const glm::dvec3& a, const glm::dvec3& b) { return glm::length(a - b); }

/// Angle in rad between two orientations.
double angleBetween(const glm::dquat& a, const glm::dquat& b) {
  return glm::length(rotationVector(a * glm::conjugate(b)));
}

class RandomPoses {
 public:
  glm::dvec3 vector(double size) { return size * glm::dvec3(unit_(engine_), unit_(engine_), unit_(engine_)); }
  Pose pose() { return {vector(2.0), fromRotationVector(vector(1.8))}; }

 private:
  std::mt19937_64 engine_{7};
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
};

TEST(Pose, QuarterTurnAboutZTakesXToY) {
  const Pose pose{glm::dvec3(1.0, 2.0, 3.0), fromRotationVector(glm::dvec3(0.0, 0.0, M_PI / 2.0))};
  EXPECT_LT(distance(transformPoint(pose, glm::dvec3(1.0, 0.0, 0.0)), glm::dvec3(1.0, 3.0, 3.0)), 1e-15);
  EXPECT_LT(distance(transformVector(pose, glm::dvec3(1.0, 0.0, 0.0)), glm::dvec3(0.0, 1.0, 0.0)), 1e-15);
}

TEST(Pose, ComposesFromRightToLeftAndInverseUndoes) {
  RandomPoses random;
  for (int i = 0; i < 200; ++i) {
    const Pose aFromB = random.pose(), bFromC = random.pose();
    const glm::dvec3 p = random.vector(3.0);
    EXPECT_LT(distance(transformPoint(aFromB * bFromC, p), transformPoint(aFromB, transformPoint(bFromC, p))),
              1e-14);
    EXPECT_LT(distance(transformPoint(inverse(aFromB) * aFromB, p), p), 1e-14);
  }
}

TEST(Pose, RotationVectorIsTheInverseOfItsQuaternionFromTinyToNearlyPi) {
  const glm::dvec3 axis = glm::normalize(glm::dvec3(1.0, -2.0, 0.5));
  for (const double angle : {0.0, 1e-300, 1e-12, 1e-7, 1e-6, 1.1e-6, 1e-3, 1.0, 3.0, M_PI - 1e-9})
    EXPECT_LT(distance(rotationVector(fromRotationVector(angle * axis)), angle * axis), 1e-15 + 1e-15 * angle)
        << angle;
}

TEST(Pose, RotationVectorTakesTheShortWay) {
  const glm::dquat q = fromRotationVector(glm::dvec3(0.0, 0.0, 1.0));
  EXPECT_LT(distance(rotationVector(-q), glm::dvec3(0.0, 0.0, 1.0)), 1e-15);
}

TEST(Pose, IntegratesAConstantTwistLikeManySmallSteps) {
  const Twist twist{glm::dvec3(0.3, -0.1, 0.2), glm::dvec3(0.5, 1.5, -0.7)};
  Pose steps;
  for (int i = 0; i < 1000; ++i) steps = integrate(steps, twist, 1e-3);
  const Pose once = integrate(Pose{}, twist, 1.0);
  EXPECT_LT(distance(steps.position, once.position), 1e-12);
  EXPECT_LT(angleBetween(steps.orientation, once.orientation), 1e-12);
}

TEST(Pose, VelocityOfAPointMatchesItsDisplacement) {
  RandomPoses random;
  for (int i = 0; i < 50; ++i) {
    const Pose pose = random.pose();
    const Twist twist{random.vector(1.0), random.vector(1.0)};
    const glm::dvec3 local = random.vector(1.0);
    const double dt = 1e-6;
    const glm::dvec3 before = transformPoint(integrate(pose, twist, -dt), local);
    const glm::dvec3 after = transformPoint(integrate(pose, twist, dt), local);
    EXPECT_LT(distance((after - before) / (2.0 * dt), velocityAt(pose, twist, transformPoint(pose, local))),
              1e-8);
  }
}

TEST(Pose, InterpolatesAtConstantSpeedBetweenItsEnds) {
  RandomPoses random;
  for (int i = 0; i < 50; ++i) {
    const Pose from = random.pose(), to = random.pose();
    const double whole = angleBetween(to.orientation, from.orientation);
    EXPECT_LT(angleBetween(interpolate(from, to, 0.0).orientation, from.orientation), 1e-13);
    EXPECT_LT(angleBetween(interpolate(from, to, 1.0).orientation, to.orientation), 1e-13);
    const Pose third = interpolate(from, to, 1.0 / 3.0);
    EXPECT_NEAR(angleBetween(third.orientation, from.orientation), whole / 3.0, 1e-12);
    EXPECT_LT(distance(third.position, glm::mix(from.position, to.position, 1.0 / 3.0)), 1e-14);
  }
}

TEST(Pose, RejectsNumbersThatAreNoPose) {
  EXPECT_TRUE(isValid(Pose{}));
  EXPECT_TRUE(isValid({glm::dvec3(1.0), -glm::dquat(1.0, 0.0, 0.0, 0.0)}));
  EXPECT_FALSE(isValid({glm::dvec3(0.0, std::nan(""), 0.0), glm::dquat(1.0, 0.0, 0.0, 0.0)}));
  EXPECT_FALSE(isValid(
      {glm::dvec3(0.0, 0.0, std::numeric_limits<double>::infinity()), glm::dquat(1.0, 0.0, 0.0, 0.0)}));
  EXPECT_FALSE(isValid({glm::dvec3(0.0), glm::dquat(std::nan(""), 0.0, 0.0, 0.0)}));
  EXPECT_FALSE(isValid({glm::dvec3(0.0), glm::dquat(0.0, 0.0, 0.0, 0.0)}));
  EXPECT_FALSE(isValid({glm::dvec3(0.0), glm::dquat(1.001, 0.0, 0.0, 0.0)}));
}

}  // namespace
}  // namespace tandem
