// Surfaces that give way under the part in the hand.

#include <memory>

#include "tests/haptics/grasp/through_part.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

constexpr double kBears = 1.5;  // N

/// Adds a part of a surface that gives way.
void addThatGivesWay(SceneBuilder& b, assets::Mesh mesh, const glm::dvec3& at) {
  b.scene.surfaces.emplace_back();
  b.scene.surfaces.back().popThroughForce = kBears;
  b.scene.materials.emplace_back();
  b.scene.materials.back().surface = 0;
  const auto material = static_cast<std::uint16_t>(b.scene.materials.size() - 1);
  for (std::uint16_t& of : mesh.triangleMaterial) of = material;
  b.addPart(mesh, {at, {1.0, 0.0, 0.0, 0.0}});
}

/// The bar 0.05 mm above a plate of `thickness` m whose upper face is z = 0.
std::unique_ptr<BarInHand> barOverSheet(double thickness) {
  SceneBuilder b;
  addBar(b, {0.0, 0.0, 0.05e-3});
  addThatGivesWay(b, boxMesh({0.2, 0.2, thickness}), {0.0, 0.0, -0.5 * thickness});
  return std::make_unique<BarInHand>(b.scene, 0);
}

void pressDown(BarInHand& hand, double way, double speed = 10e-3) {
  const int ticks = static_cast<int>(std::abs(way) / (speed * 1e-3) + 0.5);
  for (int i = 0; i < ticks; ++i) hand.by({0.0, 0.0, -way / ticks});
}

double tipOf(const BarInHand& hand) { return hand.pose(0).position.z - 30e-3; }

bool through(const BarInHand& hand) { return (hand.out.flags & haptics::kFlagPopThrough) != 0; }

TEST(HeldPopThrough, BearsUpToItsForceAndGivesWayAboveIt) {
  const auto hand = barOverSheet(2e-3);
  pressDown(*hand, 1.45e-3);  // 1.4 N
  hand->rest(300);
  EXPECT_NEAR(hand->force().z, 1.4, 0.02);
  EXPECT_NEAR(tipOf(*hand), 0.0, 5e-6);
  EXPECT_FALSE(through(*hand));
  pressDown(*hand, 0.2e-3);
  hand->rest(300);
  EXPECT_TRUE(through(*hand));
  EXPECT_NEAR(hand->force().z, 0.0, 1e-3);
  EXPECT_LT(tipOf(*hand), -1.5e-3);
}

TEST(HeldPopThrough, IsThereAgainOnceThePartHasLeftItOnEitherSide) {
  const auto hand = barOverSheet(2e-3);
  pressDown(*hand, 30e-3);
  EXPECT_TRUE(through(*hand)) << "the bar is as long as to stand in the plate";
  pressDown(*hand, -60e-3, 50e-3);
  hand->rest(100);
  EXPECT_FALSE(through(*hand));
  pressDown(*hand, 31.2e-3, 50e-3);
  hand->rest(200);
  EXPECT_NEAR(tipOf(*hand), 0.0, 5e-6) << "it bears again";
  pressDown(*hand, 100e-3, 50e-3);  // through, and out below
  hand->rest(100);
  EXPECT_FALSE(through(*hand));
  pressDown(*hand, -40e-3, 50e-3);
  hand->rest(300);
  EXPECT_NEAR(tipOf(*hand) + 60e-3, -2e-3, 5e-6) << "from below";
  EXPECT_LT(hand->force().z, -0.5);
}

TEST(HeldPopThrough, BearsABlow) {
  // 60 g at 100 mm/s that stop within a tick press with 6 N for that long.
  const auto hand = barOverSheet(2e-3);
  pressDown(*hand, 1.2e-3, 100e-3);
  hand->rest(300);
  EXPECT_FALSE(through(*hand));
  EXPECT_NEAR(tipOf(*hand), 0.0, 5e-6);
}

/// N, the most by which the force changes in a tick while the bar is pressed through.
double changeAtPop(double slipChange) {
  const auto hand = barOverSheet(2e-3);
  hand->parameters.slipChange = slipChange;
  double last = 0.0, most = 0.0;
  for (int i = 0; i < 3000; ++i) {
    hand->by({0.0, 0.0, -5e-6});
    most = std::max(most, std::abs(hand->force().z - last));
    last = hand->force().z;
  }
  EXPECT_TRUE(through(*hand));
  EXPECT_LT(hand->given, 0.0) << "what was pressed is lost";
  return most;
}

TEST(HeldPopThrough, GivesNoKick) {
  EXPECT_LT(changeAtPop(0.045), 0.09) << "as much of the spring as of the damper";
  EXPECT_GT(changeAtPop(0.0), 0.11) << "the control: nothing holds the part back";
}

TEST(HeldPopThrough, WhoLetsGoInsideTakesItOutAgain) {
  const auto hand = barOverSheet(10e-3);
  pressDown(*hand, 15e-3);
  hand->rest(300);
  ASSERT_TRUE(through(*hand));
  hand->command(haptics::PartCommand::Kind::letGo, 0);
  hand->rest(500);
  hand->command(haptics::PartCommand::Kind::grasp, 0);
  hand->rest(500);
  for (int i = 0; i < 3000; ++i) {
    hand->by({0.0, 0.0, 1e-5});
    ASSERT_LT(std::abs(hand->force().z), 0.1) << i;
  }
  EXPECT_NEAR(tipOf(*hand), hand->device().z - 30e-3, 1e-4);
}

/// A block on a frame around a hole as wide as the block is long; `feet` of the frame are of the surface that
/// gives way, and `middle` is a sheet in the hole.
std::unique_ptr<BarInHand> blockOverFrame(bool feet, bool middle) {
  SceneBuilder b;
  b.addPart(boxMesh({0.1, 0.02, 0.02}), {{0.0, 0.0, 10.05e-3}, {1.0, 0.0, 0.0, 0.0}}, 0.06);
  assets::TriangleSoup soup = moved(boxSoup({0.03, 0.1, 0.01}), {0.05, 0.0, -5e-3});
  soup = joined(soup, moved(boxSoup({0.03, 0.1, 0.01}), {-0.05, 0.0, -5e-3}));
  const std::size_t frame = soup.triangles.size();
  soup = joined(soup, moved(boxSoup({0.06, 0.1, 0.002}), {0.0, 0.0, -5e-3}));
  b.scene.surfaces.emplace_back();
  b.scene.surfaces.back().popThroughForce = kBears;
  b.scene.materials.emplace_back();
  b.scene.materials.emplace_back();
  b.scene.materials.back().surface = 0;
  const auto last = static_cast<std::uint16_t>(b.scene.materials.size() - 1);
  soup.triangleMaterial.clear();
  for (std::size_t t = 0; t < soup.triangles.size(); ++t)
    soup.triangleMaterial.push_back(
        static_cast<std::uint16_t>((t < frame ? feet : middle) ? last : last - 1));
  b.addPart(meshOf(soup), {});
  return std::make_unique<BarInHand>(b.scene, 0);
}

TEST(HeldPopThrough, TheSurfaceUnderTheFeetCountsAndNotTheOneBetweenThem) {
  for (const bool feet : {false, true}) {
    const auto hand = blockOverFrame(feet, !feet);
    pressDown(*hand, 3e-3);
    hand->rest(100);
    EXPECT_EQ(through(*hand), feet);
    EXPECT_EQ(hand->pose(0).position.z > 9.9e-3, !feet);
  }
}

TEST(HeldPopThrough, ASmoothPinStaysInASheetThinnerThanItsSamplesAreApart) {
  SceneBuilder b;
  b.addPart(meshOf(pegSoup({5e-3, 60e-3, 0.0, {64, 4}})), {{0.0, 0.0, 0.05e-3}, {1.0, 0.0, 0.0, 0.0}}, 0.06);
  addThatGivesWay(b, boxMesh({0.2, 0.2, 0.1e-3}), {0.0, 0.0, -0.05e-3});
  BarInHand hand(b.scene, 0);
  pressDown(hand, 2e-3);
  hand.rest(300);
  EXPECT_TRUE(through(hand));
  // In steps that no spacing is a multiple of.
  for (int i = 0; i < 260; ++i) {
    pressDown(hand, 0.1234e-3, 20e-3);
    ASSERT_TRUE(through(hand)) << i;
    ASSERT_LT(glm::length(hand.force()), 0.3) << i;
  }
  for (int i = 0; i < 200; ++i) {
    pressDown(hand, -0.1234e-3, 20e-3);
    ASSERT_TRUE(through(hand)) << i;
    ASSERT_LT(glm::length(hand.force()), 0.3) << i;
  }
}

}  // namespace
}  // namespace tandem::test
