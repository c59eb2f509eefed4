// Sharp, thin, hollow and round shapes pressed onto each other in any pose.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

/// A wedge of 20 mm along z whose edge lies in x = 0, y = 6 mm, `half` m to each side of it 11 mm below.
assets::TriangleSoup blade(double half) {
  return moved(prismSoup({{-half, -0.011}, {half, -0.011}, {0.0, 0.0}}, 0.02), {0.0, 0.006, -0.01});
}

assets::TriangleSoup star() {
  std::vector<glm::dvec2> outline;
  const glm::dvec2 tip(0.01, 0.0), notch(0.003, 0.002);
  for (int i = 0; i < 4; ++i) {
    const double c = i % 2 == 0 ? 1.0 - i : 0.0, s = i % 2 == 1 ? 2.0 - i : 0.0;
    for (const glm::dvec2& p : {tip, notch}) outline.emplace_back(c * p.x - s * p.y, s * p.x + c * p.y);
  }
  return prismSoup(outline, 0.006);
}

assets::TriangleSoup shape(unsigned kind) {
  switch (kind) {
    case 0:
      return boxSoup({0.01, 0.01, 0.01});
    case 1:
      return blade(0.003);
    case 2:
      return boxSoup({0.02, 0.02, 0.0005});
    case 3:
      return star();
    case 4:
      return pegSoup({0.005, 0.02, 0.001, {32, 3}});
    case 5:
      return ballSoup(0.008, {32, 12});
    case 6:
      return stairSoup(4, 0.004, 0.003, 0.02);
    case 7:
      return boxSoup({0.0006, 0.0006, 0.02});
    default:
      return blade(0.001);
  }
}

struct Pressed {
  double deepest = 0.0, end = 0.0;  // m
};

/// One shape is led 38 mm down onto the other, up to 17 mm beyond the touch, while it turns and sways.
Pressed press(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  const unsigned under = static_cast<unsigned>(random() % 9), held = static_cast<unsigned>(random() % 9);
  const auto vector = [&](double size) {
    return size * glm::dvec3{share(random), share(random), share(random)};
  };
  const glm::dquat lying = fromRotationVector(vector(3.0)), above = fromRotationVector(vector(3.0));
  const glm::dvec3 aside = vector(0.004), rotation = vector(0.3);
  const Pose start{{aside.x, aside.y, 0.04}, above};
  const double pathLength = 0.038, speed = seed % 3 == 0 ? 0.2 : 0.05;
  const DevicePath path = [=](double time) {
    const double travelled = std::min(speed * time, pathLength);
    return Pose{start.position + glm::dvec3(0.002 * std::sin(3.0 * time), 0.0, -travelled),
                fromRotationVector(rotation * (travelled / pathLength)) * start.orientation};
  };
  assets::Scene scene = sceneOfParts(
      {{.name = "under", .mesh = meshOf(shape(under)), .worldFromPart = {{0.0, 0.0, 0.0}, lying}},
       {.name = "held", .mesh = meshOf(shape(held)), .worldFromPart = start, .movable = true, .mass = 0.05}});
  HeldPartRig rig({"press", std::move(scene), 1, path, pathLength / speed + 0.3, {}});
  rig.run(5);
  return {rig.deepest(), rig.deepest(rig.last().time - 0.05)};
}

/// m, the depth of one press.
double expectWithinBounds(unsigned seed) {
  const Pressed found = press(seed);
  EXPECT_LE(found.deepest, kFastDepth) << seed;
  EXPECT_LE(found.end, kSteadyDepth) << seed;
  return found.deepest;
}

TEST(RandomPresses, GoNoDeeperThanTheirBounds) {
  for (unsigned seed = 0; seed < 24; ++seed) expectWithinBounds(seed);
}

/// A corner lies askew to the edge of a blade: of the directions across the edge few are normal to the corner
/// too.
TEST(RandomPresses, AnEdgeDoesNotCutACornerThatLiesAskewToIt) {
  for (const unsigned seed : {46u, 128u}) expectWithinBounds(seed);
}

/// The tip of a blade slides down a notch: the further flank holds it too, however little it is behind that
/// one.
TEST(RandomPresses, ATipStaysInItsNotch) {
  for (const unsigned seed : {445u, 690u, 975u}) expectWithinBounds(seed);
}

/// The corner at the end of one edge slides off another edge, and the two cross from then on. Where edges
/// count only if they cross at the start of a step, these presses go 23 to 46 um deep.
TEST(RandomPresses, EdgesDoNotPassWhereACornerSlidesOff) {
  for (const unsigned seed : {1658u, 3312u, 3442u, 3674u}) expectWithinBounds(seed);
}

/// TANDEM_SEEDS sets how many, TANDEM_FIRST_SEED the first one.
TEST(RandomPresses, OfManyNoneGoesDeeper) {
  if (!atFullSize()) GTEST_SKIP() << "set TANDEM_FULL_SIZE";
  const unsigned first = numberOf("TANDEM_FIRST_SEED", 0), count = numberOf("TANDEM_SEEDS", 1000);
  double deepest = 0.0;
  for (unsigned seed = first; seed < first + count; ++seed)
    deepest = std::max(deepest, expectWithinBounds(seed));
  std::printf("the deepest of %u presses: %.1f um\n", count, 1e6 * deepest);
}

}  // namespace
}  // namespace tandem::test
