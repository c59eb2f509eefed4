// Rectangular pegs of 4 to 16 mm through holes whose mesh is open at the mouth: with T-junctions, with cracks
// wider than rounding, without the faces at the rim, without the face around it. Nothing is there that could
// hold a peg, so that every one feels what it feels in the closed mesh.

#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "assets/gltf/load_gltf.h"
#include "haptics/touch/touching_feature.h"
#include "tests/haptics/contact/part_contact_case.h"
#include "tests/support/soup_builder.h"

namespace tandem::test {
namespace {

enum class Mouth { closed, junctions, cracked, noRim, noFloor, blind, tube, cup };
constexpr Mouth kOpenMouths[] = {Mouth::junctions, Mouth::cracked, Mouth::noRim, Mouth::noFloor};

/// A square block around the z axis with a rectangular hole from z = `depth` down to its exit in z = 0.
struct RectHole {
  Mouth mouth = Mouth::closed;
  double size = 0.008;          // m, of the peg along x; along y 7/8 of it
  double clearance = 0.144e-3;  // m, of both sides together
  double depth = 0.009;         // m
  double crack = 1e-7;          // m, by which Mouth::cracked is too wide for welding
};
constexpr int kColumns = 8;

glm::dvec2 pegSize(const RectHole& hole) { return {hole.size, 0.875 * hole.size}; }

assets::TriangleSoup rectHoleSoup(const RectHole& hole) {
  SoupBuilder b;
  const glm::dvec2 inner = pegSize(hole) + hole.clearance, outer(3.0 * hole.size);
  const auto around = [](const glm::dvec2& size, int side, int i, int n, double z) {
    const glm::dvec2 corners[] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}, {-0.5, -0.5}};
    return glm::dvec3(size * glm::mix(corners[side], corners[side + 1], static_cast<double>(i) / n), z);
  };
  const bool walls = hole.mouth == Mouth::tube || hole.mouth == Mouth::cup;
  const bool whole = hole.mouth == Mouth::closed || hole.mouth == Mouth::noRim || hole.mouth == Mouth::blind;
  const double end = hole.mouth == Mouth::noRim ? 0.06 * hole.size : 0.0,
               floor = hole.mouth == Mouth::cracked ? -hole.crack : 0.0;
  for (int side = 0; side < 4; ++side) {
    const auto in = [&](int i, int n, double z) { return around(inner, side, i, n, z); };
    const auto out = [&](int i, int n, double z) { return around(outer, side, i, n, z); };
    for (int i = 0; i < kColumns; ++i) {
      for (int row = 0; row < kColumns; ++row) {
        const double low = row == 0 ? end : hole.depth * row / kColumns,
                     high = hole.depth * (row + 1) / kColumns;
        b.quad(in(i + 1, kColumns, low), in(i, kColumns, low), in(i, kColumns, high),
               in(i + 1, kColumns, high));
      }
      if (walls) continue;
      b.quad(out(i, kColumns, 0.0), out(i + 1, kColumns, 0.0), out(i + 1, kColumns, hole.depth),
             out(i, kColumns, hole.depth));
      b.quad(out(i, kColumns, hole.depth), out(i + 1, kColumns, hole.depth), in(i + 1, kColumns, hole.depth),
             in(i, kColumns, hole.depth));
    }
    if (walls || hole.mouth == Mouth::noFloor) continue;
    const int columns = whole ? kColumns : 1;
    for (int i = 0; i < columns; ++i)
      b.quad(out(i + 1, columns, floor), out(i, columns, floor), in(i, columns, floor),
             in(i + 1, columns, floor));
  }
  if (hole.mouth == Mouth::blind || hole.mouth == Mouth::cup)
    b.quad(around(inner, 0, 0, 1, 0.0), around(inner, 1, 0, 1, 0.0), around(inner, 2, 0, 1, 0.0),
           around(inner, 3, 0, 1, 0.0));
  return b.soup;
}

/// A peg of 50 mm led down through a hole at 20 mm/s until its tip is half the depth below the exit. Inside
/// it sways, turns and leans, all by the seed: at `sway` 1 by more than its play.
PartCase rectPegCase(const RectHole& hole, std::uint32_t seed, assets::Mesh block, double sway = 1.0) {
  PartCase made;
  made.name = "mouth_" + std::to_string(static_cast<int>(hole.mouth)) + "_" +
              std::to_string(static_cast<int>(1e3 * hole.size)) + "mm_seed" + std::to_string(seed);
  const double length = 0.05, top = hole.depth + 0.5 * length;
  made.scene = sceneOfParts({{"peg", meshOf(boxSoup(glm::dvec3(pegSize(hole), length), kColumns)), {}, true},
                             {"hole", std::move(block)}});
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const double lean = M_PI * any(random), x = 3.0 * any(random), y = 3.0 * any(random),
               turn = 3.0 * any(random);
  made.path = [=](double time) {
    const double down = std::min(0.02 * time, 0.001 + 1.5 * hole.depth);
    const double inside = sway * std::clamp((down - 0.001) / 0.003, 0.0, 1.0), w = 2.0 * M_PI * time;
    Pose pose;
    pose.position = {0.0004 * inside * std::sin(3.0 * w + x), 0.0004 * inside * std::cos(2.3 * w + y),
                     top + 0.001 - down};
    pose.orientation = glm::angleAxis(0.03 * inside * std::sin(2.9 * w + turn), glm::dvec3(0, 0, 1)) *
                       glm::angleAxis(0.016 * inside, glm::dvec3(std::cos(lean), std::sin(lean), 0.0));
    return pose;
  };
  made.duration = 0.8;
  made.scene.parts[0].worldFromPart = made.path(0.0);
  return made;
}

/// The most force along the hole while the tip is in the lower half of it or below, N.
double mostAlong(const HeldPartRig& rig, const RectHole& hole) {
  double most = 0.0;
  for (const RigTick& t : rig.ticks())
    if (t.part.position.z < 0.025 + 0.5 * hole.depth) most = std::max(most, std::abs(t.toHand.force.z));
  return most;
}

void expectPasses(const RectHole& hole, std::uint32_t seed, assets::Mesh block) {
  HeldPartRig rig(rectPegCase(hole, seed, std::move(block)));
  rig.run(0);
  report(rig);
  expectSound(rig);
  const std::string& name = rig.given().name;
  EXPECT_NEAR(rig.last().part.position.z, rig.last().device.position.z, 50e-6) << name;
  EXPECT_LE(mostAlong(rig, hole), 0.25) << name;
  EXPECT_LE(quantile(rig.forceSteps(), 1.0), 0.25) << name;
}

TEST(OpenMouths, LetEveryPegPassToItsDepth) {
  const double sizes[] = {0.004, 0.008, 0.012, 0.016};
  for (std::size_t k = 0; k < 4; ++k)
    for (std::uint32_t seed = 0; seed < (atFullSize() ? 5u : 1u); ++seed)
      for (std::size_t m = 0; m < 4; ++m) {
        // Each mouth with one size; all of them at full size.
        if (!atFullSize() && m != k) continue;
        const RectHole hole{.mouth = kOpenMouths[m], .size = sizes[k]};
        expectPasses(hole, seed, meshOf(rectHoleSoup(hole)));
      }
}

/// A negative control: the same run notices a lid where there is one.
TEST(OpenMouths, AFloorIsNoMouth) {
  const RectHole hole{.mouth = Mouth::blind, .size = 0.006};
  HeldPartRig rig(rectPegCase(hole, 0, meshOf(rectHoleSoup(hole))));
  rig.run(0);
  EXPECT_NEAR(rig.last().part.position.z, 0.025, 1e-4);
  EXPECT_GT(mostAlong(rig, hole), 3.0);
}

/// A single sheet whose faces look outwards has a mouth like one whose faces look inwards.
TEST(OpenMouths, OfSheetsLetPegsInWhicheverWayTheirFacesLook) {
  for (const Mouth mouth : {Mouth::tube, Mouth::cup})
    for (const bool outwards : {false, true}) {
      if (!atFullSize() && outwards == (mouth == Mouth::cup)) continue;
      const RectHole hole{.mouth = mouth};
      assets::TriangleSoup soup = rectHoleSoup(hole);
      if (outwards) soup = insideOut(std::move(soup));
      HeldPartRig rig(rectPegCase(hole, 3, meshOf(std::move(soup)), 0.1));
      rig.run(0);
      report(rig);
      expectSound(rig);
      const double lowest = mouth == Mouth::cup ? 0.0 : -0.5 * hole.depth;
      EXPECT_NEAR(rig.last().part.position.z, 0.025 + lowest, 1e-4) << rig.given().name << outwards;
    }
}

/// The bottom edge of a peg at random places before the exit of a hole, moving down: how often a plane holds
/// it up although it is over no face.
int heldUp(const RectHole& hole, const haptics::TriangleBvh& tree, const haptics::MeshEdges& edges,
           double scale) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const glm::dvec2 half = 0.5 * (pegSize(hole) + hole.clearance);
  int held = 0;
  for (int i = 0; i < 4000; ++i) {
    const int axis = i % 2;
    const double side = any(random) < 0.0 ? -1.0 : 1.0;
    glm::dvec3 outward(0.0), along(0.0), point(0.0);
    outward[axis] = side;
    along[1 - axis] = 1.0;
    point[axis] = side * (half[axis] + 1e-6 * any(random));
    point[1 - axis] = 0.95 * half[1 - axis] * any(random);
    point.z = 2e-5 * any(random);
    const std::array<glm::dvec3, 2> normals{glm::dvec3(0, 0, -1), outward};
    haptics::SampleQuery sample;
    sample.point = scale * point;
    sample.motion = scale * glm::dvec3(1e-5 * any(random), 1e-5 * any(random), -4e-5);
    sample.normals = normals;
    sample.edge = along;
    sample.along = scale * 2e-4;
    sample.slack = scale * 1e-7;
    sample.outside = true;
    sample.range = scale * 1e-5;
    haptics::TouchingFeature found;
    EXPECT_TRUE(touchingFeature(tree, edges, sample, 1e300, haptics::kNoTriangle, found));
    for (int p = 0; p < found.count; ++p) {
      const haptics::TouchingPlane& plane = found.planes[static_cast<std::size_t>(p)];
      const double predicted = plane.gap + glm::dot(plane.normal, sample.motion);
      held += plane.normal.z > 0.3 && predicted < 0.0 ? 1 : 0;
    }
  }
  return held;
}

/// With a negative control: were each border to have the back of its face, a peg would be held.
TEST(OpenMouths, HoldNothingUpAtAnyScale) {
  for (const double scale : {1e-3, 1.0, 1e3})
    for (const Mouth mouth :
         {Mouth::closed, Mouth::junctions, Mouth::cracked, Mouth::noRim, Mouth::noFloor}) {
      const RectHole hole{.mouth = mouth};
      assets::TriangleSoup soup = rectHoleSoup(hole);
      for (glm::dvec3& p : soup.positions) p *= scale;
      const assets::Mesh mesh = meshOf(std::move(soup));
      const haptics::TriangleBvh tree(mesh, 1);
      const int held = heldUp(hole, tree, haptics::MeshEdges(mesh).ofSolid(), scale);
      EXPECT_EQ(held, 0) << scale << " mouth " << static_cast<int>(mouth);
      if (mouth == Mouth::noRim) {
        const int control = heldUp(hole, tree, haptics::MeshEdges(mesh), scale);
        EXPECT_GT(control, 20) << scale;
      }
    }
}

/// The path of a public assembly benchmark, of the hand that takes the peg 25 mm over its tip.
DevicePath pathOf(const std::string& file) {
  std::vector<Pose> poses;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    double time = 0.0;
    Pose p;
    numbers >> time >> p.position.x >> p.position.y >> p.position.z >> p.orientation.w >> p.orientation.x >>
        p.orientation.y >> p.orientation.z;
    poses.push_back(p);
  }
  return [poses](double time) {
    return poses[std::min(poses.size() - 1, static_cast<std::size_t>(1000.0 * time + 0.5))];
  };
}

TEST(OpenMouths, ThePegOfAnAssemblyBenchmarkFollowsTheHand) {
  const char* data = std::getenv("TANDEM_DATA");
  if (data == nullptr) GTEST_SKIP() << "TANDEM_DATA is not set";
  const std::string file = std::string(data) + "/factory_rect_8mm_tight";
  Result<assets::Scene> scene = assets::loadGltf(file + ".glb", {});
  ASSERT_TRUE(scene.ok());
  PartCase given;
  given.name = "factory_rect_8mm_tight";
  given.held = assets::findPart(*scene, "peg");
  given.scene = std::move(*scene);
  given.path = pathOf(file + "_path.csv");
  given.duration = 1.25;
  HeldPartRig rig(std::move(given));
  rig.run(0);
  report(rig);
  expectSound(rig);
  EXPECT_NEAR(rig.last().device.position.z - rig.last().part.position.z, 0.025, 1e-4);
  // At 0.8 s a jam of 7 N opens, which may change the force by slipChange a tick.
  for (const RigTick& t : rig.ticks()) {
    if (t.time >= 1.0) {
      EXPECT_LE(std::abs(t.toHand.force.z), 0.25) << t.time;
    }
  }
}

}  // namespace
}  // namespace tandem::test
