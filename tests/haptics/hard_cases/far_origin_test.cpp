// Contact a hundred kilometres from the origin: what coordinates lose there, and nothing more.

#include <cmath>

#include "tests/haptics/hard_cases/hard_case.h"

namespace tandem::test {
namespace {

const glm::dvec3 kFar(1e5, -1e5, 1e5);  // m, whatever the scale

/// A hand at a box of 0.2 x 0.2 x 0.1, scaled, around `origin`; it thinks in unscaled lengths from there.
class FarHand {
 public:
  FarHand(double by, const glm::dvec3& at, double ball, bool bakedIn, bool asFloat = false)
      : scale(by), origin(at), inFloat(asFloat), probe(sceneAt(by, at, bakedIn, asFloat)) {
    probe.parameters.toolRadius = ball * by;
  }
  glm::dvec3 at(const glm::dvec3& p) {
    return probe.at(kept(scale * p + origin, inFloat)).hands[0].toHand.force / scale;
  }
  double skin() { return probe.state.data().world.skin(0, probe.out.worldFromProxy.position) / scale; }

  double scale;
  glm::dvec3 origin;
  bool inFloat;
  HandProbe probe;

 private:
  static glm::dvec3 kept(const glm::dvec3& p, bool inFloat) { return inFloat ? glm::dvec3(glm::vec3(p)) : p; }
  /// Far away by the pose of the part, or by the coordinates of its mesh.
  static assets::Scene sceneAt(double scale, const glm::dvec3& origin, bool bakedIn, bool inFloat) {
    assets::Mesh mesh = scaledMesh(boxMesh({0.2, 0.2, 0.1}), scale);
    if (bakedIn) {
      for (glm::dvec3& p : mesh.positions) p = kept(p + origin, inFloat);
      mesh.bounds.min += origin;
      mesh.bounds.max += origin;
    }
    SceneBuilder b;
    b.addPart(std::move(mesh), {bakedIn ? glm::dvec3(0.0) : origin, {1.0, 0.0, 0.0, 0.0}});
    return b.scene;
  }
};

/// Lands 2 mm deep, slides over the face and off it, comes back at the side. Compares with the same at the
/// origin.
void strokeBox(double scale, double ball, bool bakedIn) {
  FarHand far(scale, kFar, ball, bakedIn), near(scale, glm::dvec3(0.0), ball, bakedIn);
  double worst = 0.0, most = 0.0;
  int touching = 0;
  const auto both = [&](const glm::dvec3& p) {
    const glm::dvec3 there = far.at(p), here = near.at(p);
    touching += far.probe.out.contactCount > 0 ? 1 : 0;
    worst = std::max(worst, glm::length(there - here));
    most = std::max(most, std::abs(there.z - kStiffness * 0.002));
    EXPECT_TRUE(std::isfinite(there.x + there.y + there.z));
  };
  const double top = 0.05 + ball;
  for (int i = 0; i <= 50; ++i) both({0.011, 0.007, top + 0.003 - 1e-4 * i});
  worst = most = 0.0;
  for (int i = 0; i <= 300; ++i) both({0.011 + 2e-4 * i, 0.007 + 1e-4 * i, top - 0.002});
  // A coordinate out there is worth 2^-36 m, a skin of it 2^-42 of its size: so much may the depth be off.
  const double allowed = 4.0 * kStiffness * far.skin();
  EXPECT_LE(worst, allowed);
  EXPECT_LE(most, allowed);
  EXPECT_GE(touching, 301);
  EXPECT_LE(far.skin() * scale, 0x1p-42 * 6.0 * glm::length(kFar) + 1e-9 * scale);
}

TEST(HardOrigin, AHundredKilometresAwayTheSameIsFelt) {
  for (const double scale : kScales) {
    for (const double ball : {0.0, 0.001}) {
      for (const bool bakedIn : {false, true}) {
        SCOPED_TRACE(testing::Message() << "scale " << scale << " ball " << ball << " baked in " << bakedIn);
        strokeBox(scale, ball, bakedIn);
      }
    }
  }
}

TEST(HardOrigin, ScaledScenesAgreeThereWithinWhatTheirCoordinatesAreWorth) {
  std::vector<glm::dvec3> first;
  double firstSkin = 0.0;
  for (const double scale : {20.0, 1.0, 1e-3}) {
    FarHand hand(scale, kFar, 0.0, false);
    std::vector<glm::dvec3> forces;
    hand.at({0.011, 0.007, 0.053});
    for (int i = 0; i <= 200; ++i) forces.push_back(hand.at({0.011 + 2e-4 * i, 0.007, 0.048}));
    if (first.empty()) {
      first = forces;
      firstSkin = hand.skin();
    }
    for (std::size_t i = 0; i < forces.size(); ++i) {
      ASSERT_LE(glm::length(forces[i] - first[i]), 4.0 * kStiffness * (hand.skin() + firstSkin)) << scale;
    }
  }
}

/// How far the force at 2 mm is off on a stroke over a box out there, N.
double worstOnAStroke(bool inFloat) {
  FarHand hand(1.0, kFar, 0.0, true, inFloat);
  hand.at({0.011, 0.007, 0.053});
  double worst = 0.0;
  for (int i = 0; i <= 300; ++i) {
    const glm::dvec3 force = hand.at({0.011 + 2e-4 * i, 0.007 + 1e-4 * i, 0.048});
    worst = std::max(worst, std::abs(force.z - kStiffness * 0.002));
  }
  return worst;
}

/// The negative control: the same box and hand with coordinates rounded to float, which out there are 7.8 mm
/// apart.
TEST(HardOrigin, FloatCoordinatesDoNotKeepIt) {
  EXPECT_LE(worstOnAStroke(false), 1e-4 * kStiffness * 0.002);
  EXPECT_GT(worstOnAStroke(true), 0.5 * kStiffness * 0.002);
}

}  // namespace
}  // namespace tandem::test
