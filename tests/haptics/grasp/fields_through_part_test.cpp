// Force fields on the part in the hand.

#include <random>

#include "tests/haptics/fields/field_samples.h"
#include "tests/haptics/grasp/through_part.h"

namespace tandem::test {
namespace {

assets::Scene barIn(const std::vector<ForceField>& fields) {
  SceneBuilder b;
  addBar(b, {0.0, 0.0, -30e-3});  // its centre is the origin
  b.scene.fields = fields;
  return b.scene;
}

TEST(FieldsThroughPart, ASpringDrawsThePartAtItsCentreWhereverItIsGripped) {
  ForceField field = spring(200.0);
  field.partFromField.position = {5e-3, 0.0, 0.0};
  BarInHand hand(barIn({field}), 0);
  hand.rest(700);
  // Two springs in series: 200 (5 mm - x) = 1000 x.
  const double x = 200.0 * 5e-3 / 1200.0;
  EXPECT_NEAR(hand.pose(0).position.x, x, 1e-6);
  EXPECT_NEAR(hand.force().x, 1000.0 * x, 1e-3);
}

TEST(FieldsThroughPart, ThePartFeelsTheFieldOfWhereItIsAndNotOfTheHand) {
  ForceField wind;
  wind.force = {1.0, 0.0, 0.0};
  wind.region = sphere(0.1, 0.02);
  for (const bool atPart : {true, false}) {
    wind.partFromField.position = {0.0, 0.0, atPart ? 0.0 : 0.2};
    BarInHand hand(barIn({wind}), 0, 2.0, {0.0, 0.0, 0.2});
    hand.parameters.graspRotStiffness = 400.0;
    hand.rest(1500);
    EXPECT_NEAR(hand.force().x, atPart ? 1.0 : 0.0, 1e-2);
  }
}

TEST(FieldsThroughPart, TheForceChangesOverFromTheTipToThePartWithoutAStep) {
  ForceField wind;
  wind.force = {1.0, 0.0, 0.0};
  SceneBuilder b;
  addBar(b, {0.0, 0.0, -30e-3});
  b.scene.fields = {wind};
  BarInHand hand(b.scene, 0);
  double last = hand.force().x;
  for (int i = 0; i < 1000; ++i) {
    hand.rest(1);
    EXPECT_LT(std::abs(hand.force().x - last), 0.02) << i;
    EXPECT_LT(hand.force().x, 1.2);
    last = hand.force().x;
  }
  EXPECT_NEAR(last, 1.0, 1e-3);
}

TEST(FieldsThroughPart, AViscousFieldDragsThePart) {
  ForceField honey;
  honey.kind = Kind::viscosity;
  honey.damping = glm::dvec3(5.0);
  BarInHand hand(barIn({honey}), 0);
  hand.rest(500);
  for (int i = 0; i < 1000; ++i) hand.by({1e-4, 0.0, 0.0});
  EXPECT_NEAR(hand.force().x, -0.5, 1e-3);
}

/// J beyond what sampling explains, over a random stroke that ends where it began.
double excessOfField(const ForceField& field, std::uint32_t seed) {
  BarInHand hand(barIn({field}), 0, 0.0);
  hand.rest(700);  // the field has faded in
  hand.given = hand.sampling = 0.0;
  const glm::dvec3 start = hand.device(), spring = hand.force();
  std::mt19937 random(seed);
  std::normal_distribution<double> kick(0.0, 4e-6);
  glm::dvec3 v(0.0);
  for (int i = 0; i < 1500; ++i) {
    v = 0.995 * v + glm::dvec3(kick(random), kick(random), kick(random)) - 2e-5 * (hand.device() - start);
    hand.by(v);
  }
  for (int i = 0; i < 500; ++i) hand.by((start - hand.device()) / (500.0 - i));
  hand.rest(700);
  return hand.given - hand.sampling - 0.5 * glm::dot(spring, spring) / BarInHand::kStiffness;
}

TEST(FieldsThroughPart, ConservativeFieldsGiveNoEnergyOnClosedPaths) {
  for (const ForceField& field : storedFields()) {
    if (field.maxForce > 0.0 && field.kind == Kind::potential) continue;  // cut short: kFlagFieldLimited
    for (std::uint32_t seed = 0; seed < 1; ++seed)
      EXPECT_LT(excessOfField(field, seed), 1e-6) << assets::nameOf(field.kind) << ' ' << seed;
  }
}

TEST(FieldsThroughPart, TheAccountSeesASource) {
  // The control of the test above: a wind within a region, entered with the wind and left across it.
  ForceField wind;
  wind.force = {1.0, 0.0, 0.0};
  wind.region = box({0.01, 0.01, 1.0}, 0.002);
  BarInHand hand(barIn({wind}), 0, 0.0);
  hand.rest(700);
  hand.given = hand.sampling = 0.0;
  for (int i = 0; i < 500; ++i) hand.by({2e-5, 0.0, 0.0});
  for (int i = 0; i < 1000; ++i) hand.by({0.0, 2e-5, 0.0});
  for (int i = 0; i < 500; ++i) hand.by({-2e-5, 0.0, 0.0});
  for (int i = 0; i < 1000; ++i) hand.by({0.0, -2e-5, 0.0});
  EXPECT_GT(hand.given - hand.sampling, 2e-3);
}

}  // namespace
}  // namespace tandem::test
