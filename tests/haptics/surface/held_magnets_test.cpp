// Magnets near the part in the hand.

#include <cmath>
#include <memory>
#include <random>

#include "tests/haptics/grasp/through_part.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

constexpr double kPull = 0.8, kPullReach = 8e-3;  // N, m
constexpr PartId kBarPart = 0, kMagnetPart = 1;

double pullAt(double height) {
  const double x = height / kPullReach;
  return x > 0.0 && x < 1.0 ? 4.0 * kPull * x * (1.0 - x) : 0.0;
}

/// Adds a material that is a magnet.
std::uint16_t addMagnetic(SceneBuilder& b) {
  b.scene.surfaces.emplace_back();
  b.scene.surfaces.back().magneticForce = kPull;
  b.scene.surfaces.back().magneticDistance = kPullReach;
  b.scene.materials.emplace_back();
  b.scene.materials.back().surface = static_cast<std::uint16_t>(b.scene.surfaces.size() - 1);
  return static_cast<std::uint16_t>(b.scene.materials.size() - 1);
}

PartId addMagnet(SceneBuilder& b, assets::Mesh mesh, const glm::dvec3& at, double mass = 0.0) {
  const std::uint16_t material = addMagnetic(b);
  for (std::uint16_t& of : mesh.triangleMaterial) of = material;
  return b.addPart(mesh, {at, {1.0, 0.0, 0.0, 0.0}}, mass);
}

/// The bar with its lower end `height` m over a magnet whose upper face is z = 0.
std::unique_ptr<BarInHand> barOverMagnet(double height, const glm::dvec3& magnet = {0.2, 0.2, 0.02},
                                         double damping = 2.0) {
  SceneBuilder b;
  addBar(b, {0.0, 0.0, height});
  addMagnet(b, boxMesh(magnet), {0.0, 0.0, -0.5 * magnet.z});
  return std::make_unique<BarInHand>(b.scene, kBarPart, damping);
}

/// m, of the lowest corner of the bar.
double heightOf(const BarInHand& hand) {
  double least = 1e300;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner{i & 1 ? 5e-3 : -5e-3, i & 2 ? 5e-3 : -5e-3, i & 4 ? 30e-3 : -30e-3};
    least = std::min(least, transformPoint(hand.pose(kBarPart), corner).z);
  }
  return least;
}

TEST(HeldMagnets, PullHardestAtHalfTheirDistance) {
  for (const double height : {1e-3, 2e-3, 4e-3, 6e-3, 7.5e-3}) {
    const auto hand = barOverMagnet(height);
    hand->rest(1500);
    EXPECT_NEAR(hand->force().z, -pullAt(heightOf(*hand)), 1e-3) << height;
    EXPECT_LT(heightOf(*hand), height);
    EXPECT_NEAR(std::hypot(hand->force().x, hand->force().y), 0.0, 1e-3);
  }
  const auto beyond = barOverMagnet(8.1e-3);
  beyond->rest(500);
  EXPECT_EQ(beyond->force().z, 0.0);
}

TEST(HeldMagnets, PullAtTheCornerThatIsNearest) {
  SceneBuilder b;
  const PartId bar = addBar(b, {0.0, 0.0, 0.0});
  const glm::dquat turn = glm::angleAxis(0.6, glm::normalize(glm::dvec3(1.0, 0.4, 0.0)));
  b.scene.parts[bar].worldFromPart.orientation = turn;
  addMagnet(b, boxMesh({0.4, 0.4, 0.02}), {0.0, 0.0, -0.01});
  BarInHand hand(b.scene, bar);
  hand.parameters.graspRotStiffness = 400.0;
  hand.rest(1500);
  hand.by({0.0, 0.0, 3e-3 - heightOf(hand)});
  hand.rest(1500);
  EXPECT_NEAR(hand.force().z, -pullAt(heightOf(hand)), 1e-3);
  EXPECT_GT(pullAt(heightOf(hand)), 0.3);
}

TEST(HeldMagnets, ASmallOneUnderTheMiddleOfAWideFaceIsFound) {
  SceneBuilder b;
  const PartId plate = b.addPart(boxMesh({0.2, 0.2, 0.01}), {{0.0, 0.0, 9e-3}, {1.0, 0.0, 0.0, 0.0}}, 0.5);
  addMagnet(b, boxMesh({2e-3, 2e-3, 2e-3}), {0.03, -0.02, -1e-3});
  BarInHand hand(b.scene, plate);
  hand.parameters.graspRotStiffness = 400.0;
  hand.rest(3000);
  EXPECT_NEAR(hand.force().z, -pullAt(hand.pose(plate).position.z - 5e-3), 5e-3);
  EXPECT_LT(hand.force().z, -0.5);
}

TEST(HeldMagnets, OnlyTheirOwnFacesPull) {
  SceneBuilder b;
  addBar(b, {0.0, 0.0, 4e-3});
  const std::uint16_t magnetic = addMagnetic(b);
  assets::Mesh plate = boxMesh({0.2, 0.2, 0.02});
  for (std::size_t t = 0; t < plate.triangles.size(); ++t) {
    bool below = true;
    for (const std::uint32_t v : plate.triangles[t]) below = below && plate.positions[v].z < 0.0;
    if (below) plate.triangleMaterial[t] = magnetic;
  }
  b.addPart(plate, {{0.0, 0.0, -0.01}, {1.0, 0.0, 0.0, 0.0}});
  BarInHand hand(b.scene, kBarPart);
  hand.rest(500);
  EXPECT_EQ(hand.force().z, 0.0) << "the upper face, 4 mm away, is no magnet";
}

TEST(HeldMagnets, ComeGraduallyWithAGrasp) {
  const auto hand = barOverMagnet(4e-3);
  double last = 0.0;
  for (int i = 0; i < 1000; ++i) {
    hand->rest(1);
    EXPECT_LT(std::abs(hand->force().z - last), 0.03) << i;
    last = hand->force().z;
  }
  EXPECT_LT(last, -0.7);
}

/// J beyond what sampling explains, over a random stroke among two magnets of this force (N) that ends where
/// it began; the bar turns as it is pulled.
double excessOfMagnets(double force, std::uint32_t seed) {
  SceneBuilder b;
  addBar(b, {0.0, 0.0, 3e-3});
  addMagnet(b, boxMesh({0.02, 0.02, 0.02}), {0.0, 0.0, -0.01});
  addMagnet(b, boxMesh({0.004, 0.03, 0.03}), {0.012, 0.0, 0.02});
  for (assets::Surface& surface : b.scene.surfaces) surface.magneticForce = force;
  BarInHand hand(b.scene, kBarPart, 0.0);
  hand.rest(1500);
  hand.given = hand.sampling = 0.0;
  const glm::dvec3 start = hand.device(), spring = hand.force();
  std::mt19937 random(seed);
  std::normal_distribution<double> kick(0.0, 6e-6);
  glm::dvec3 v(0.0);
  for (int i = 0; i < 3000; ++i) {
    v = 0.995 * v + glm::dvec3(kick(random), kick(random), kick(random)) - 2e-5 * (hand.device() - start);
    hand.by(v);
  }
  for (int i = 0; i < 500; ++i) hand.by((start - hand.device()) / (500.0 - i));
  hand.rest(1000);
  return hand.given - hand.sampling - 0.5 * glm::dot(spring, spring) / BarInHand::kStiffness;
}

TEST(HeldMagnets, GiveNoEnergyOnClosedPaths) {
  // 400 N/m beside the coupling's 1000, and 500,000 N/m on 60 g.
  for (const double force : {0.8, 1000.0})
    for (std::uint32_t seed = 0; seed < 3; ++seed)
      EXPECT_LT(excessOfMagnets(force, seed), 1e-6) << force << ' ' << seed;
}

TEST(HeldMagnets, TheAccountSeesOneThatIsTakenAway) {
  // The control of the test above: in to the magnet, which is then taken away, out, and it is put back.
  const auto hand = barOverMagnet(8.5e-3, {0.2, 0.2, 0.02}, 0.0);
  hand->rest(500);
  hand->given = hand->sampling = 0.0;
  const Pose place = hand->pose(kMagnetPart);
  for (int i = 0; i < 800; ++i) hand->by({0.0, 0.0, -1e-5});
  hand->put(kMagnetPart, {place.position - glm::dvec3(0.0, 0.0, 0.1), place.orientation});
  for (int i = 0; i < 800; ++i) hand->by({0.0, 0.0, 1e-5});
  hand->put(kMagnetPart, place);
  // 2/3 F D = 4.3 mJ.
  EXPECT_GT(hand->given - hand->sampling, 2e-3);
}

/// The bar 5 mm over a ball of 20 g that lies on a table, after it has jumped up to the bar.
std::unique_ptr<BarInHand> barOverFreeMagnet() {
  SceneBuilder b;
  addBar(b, {0.0, 0.0, 5e-3});
  const PartId magnet = addMagnet(b, sphereMesh(5e-3, 32), {0.0, 0.0, -5e-3}, 0.02);
  b.scene.parts[magnet].movable = true;
  b.addPart(boxMesh({0.2, 0.2, 0.02}), {{0.0, 0.0, -0.02}, {1.0, 0.0, 0.0, 0.0}});
  for (assets::Part& part : b.scene.parts) part.gravityFactor = 1.0;
  auto hand = std::make_unique<BarInHand>(b.scene, kBarPart);
  hand->parameters.gravity = {0.0, 0.0, -9.81};
  hand->command(haptics::PartCommand::Kind::own, magnet);
  hand->rest(1500);
  return hand;
}

TEST(HeldMagnets, AFreeOneIsPulledAsHardAsItPulls) {
  const auto made = barOverFreeMagnet();
  BarInHand& hand = *made;
  EXPECT_GT(hand.pose(kMagnetPart).position.z, -4.9e-3) << "it has jumped up to the bar";
  const double gap = heightOf(hand) - hand.pose(kMagnetPart).position.z - 5e-3;
  EXPECT_NEAR(pullAt(gap), 0.02 * 9.81, 2e-3) << "and hangs where the pull bears it";
  EXPECT_NEAR(hand.force().z, -0.08 * 9.81, 5e-3) << "the hand bears both";
}

TEST(HeldMagnets, DragNothingAcrossTheirPull) {
  const auto hand = barOverMagnet(3e-3, {0.4, 0.2, 0.02});
  hand->rest(1000);
  for (int i = 0; i < 500; ++i) {
    hand->by({2e-4, 0.0, 0.0});
    if (i > 350) {
      ASSERT_LT(std::abs(hand->force().x), 0.02) << i << ": 0.065 N if the spring were isotropic";
    }
  }
  EXPECT_LT(hand->force().z, -0.5);
}

TEST(HeldMagnets, OneThatIsCarriedWeighsWhatItWeighs) {
  const auto made = barOverFreeMagnet();
  BarInHand& hand = *made;
  for (int i = 0; i < 1000; ++i) {
    hand.by({0.0, 0.0, 5e-5});
    if (i > 300) {
      ASSERT_NEAR(hand.force().z, -0.08 * 9.81, 0.02) << i;
    }
  }
  EXPECT_GT(hand.pose(kMagnetPart).position.z, 40e-3);
}

TEST(HeldMagnets, ThoseOutOfReachTakeNoneOfItsPull) {
  SceneBuilder b;
  addBar(b, {0.0, 0.0, 3e-3});
  // Long strips 12 mm beside the bar, whose bounding spheres hold it, before and behind the one that pulls.
  for (int i = 0; i < 12; ++i)
    addMagnet(b, boxMesh({0.002, 0.3, 0.002}), {17e-3 + 3e-3 * (i / 4), 0.0, 10e-3 * (i % 4 + 1)});
  const PartId near = addMagnet(b, boxMesh({0.2, 0.2, 0.02}), {0.0, 0.0, -0.01});
  for (int i = 0; i < 12; ++i)
    addMagnet(b, boxMesh({0.002, 0.3, 0.002}), {-17e-3 - 3e-3 * (i / 4), 0.0, 10e-3 * (i % 4 + 1)});
  ASSERT_EQ(near, 13u);
  BarInHand hand(b.scene, kBarPart);
  hand.rest(1500);
  EXPECT_NEAR(hand.force().z, -pullAt(heightOf(hand)), 1e-3);
  EXPECT_LT(hand.force().z, -0.5);
}

}  // namespace
}  // namespace tandem::test
