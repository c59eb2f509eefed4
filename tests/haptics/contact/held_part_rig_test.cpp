#include "tests/support/held_part_rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "assets/gltf/load_gltf.h"
#include "tests/support/part_case_files.h"

namespace tandem::test {
namespace {

PartCase alone(DevicePath path, double duration) {
  PartCase made{"alone",
                sceneOfParts({{"cube", meshOf(boxSoup(glm::dvec3(0.01))), path(0.0), true},
                              {"floor", meshOf(moved(boxSoup(glm::dvec3(0.06)), {0.0, 0.0, -0.03}))}}),
                0,
                path,
                duration,
                {}};
  return made;
}

TEST(HeldPartRig, PartFollowsItsPathWhereNothingIsInTheWay) {
  HeldPartRig rig(alone(
      [](double t) {
        return Pose{{0.02 * t, 0.0, 0.02}, fromRotationVector({0.0, 0.3 * t, 0.0})};
      },
      1.0));
  rig.run();
  EXPECT_EQ(rig.ticks().size(), 1000u);
  EXPECT_LT(rig.finalOffset(rig.last().device), 1e-5);
  EXPECT_LT(rig.finalTurn(rig.last().device), 1e-3);
  EXPECT_EQ(rig.deepest(), 0.0);
  EXPECT_GT(quantile(rig.cpuTimes(), 0.5), 0.0);
}

TEST(HeldPartRig, MeasuresDepthWhereTheTickLeftThePart) {
  // Grasped 1 mm deep in the floor: the first measurement is of the tick of the grasp.
  HeldPartRig rig(alone([](double) { return Pose{{0.003, 0.002, 0.004}, {1.0, 0.0, 0.0, 0.0}}; }, 0.002));
  rig.run(1);
  EXPECT_NEAR(rig.ticks()[0].depth, 0.005 - rig.ticks()[0].part.position.z, 1e-8);
}

TEST(HeldPartRig, CountsWhatTheHandIsGiven) {
  // Down against the weightless part's inertia and back: a coupling with damping creates no energy.
  HeldPartRig rig(alone(
      [](double t) {
        return Pose{{0.0, 0.0, 0.03 + 0.002 * std::sin(20.0 * t)}, {1.0, 0.0, 0.0, 0.0}};
      },
      1.0));
  rig.run(0);
  EXPECT_LT(rig.energyGiven(), 1e-4);
  EXPECT_TRUE(std::isnan(rig.last().depth));
  EXPECT_EQ(rig.forceSteps().size(), 999u);
}

TEST(PartCases, StartClearOfTheirNeighboursOrTouching) {
  for (const PartCase& given : allPartCases()) {
    if (given.name == "cube_in_block") continue;  // meant to start inside
    const haptics::ContactScene contact(given.scene, 1);
    std::vector<Pose> poses;
    for (const assets::Part& part : given.scene.parts) poses.push_back(part.worldFromPart);
    EXPECT_LT(haptics::HeldPartDepthMeter(contact, given.held).measure(poses).depth, 1e-9) << given.name;
  }
}

TEST(PartCases, PathsWouldGoThroughTheNeighboursIfNothingHeldThePart) {
  // The control of all cases: where the hand leads, the part must be stopped.
  const std::set<std::string> still{"cube_at_rest", "peg_at_rest"};
  for (const PartCase& given : allPartCases()) {
    if (still.count(given.name) > 0) continue;
    const haptics::ContactScene contact(given.scene, 1);
    haptics::HeldPartDepthMeter meter(contact, given.held);
    std::vector<Pose> poses;
    for (const assets::Part& part : given.scene.parts) poses.push_back(part.worldFromPart);
    // Plates are passed within a tick.
    const double step = given.name.rfind("plate", 0) == 0 ? 1e-4 : 0.02;
    double deepest = 0.0;
    for (double time = 0.0; time < given.duration && deepest <= 40e-6; time += step) {
      poses[given.held] = given.path(time);
      deepest = std::max(deepest, meter.measure(poses).depth);
    }
    EXPECT_GT(deepest, 40e-6) << given.name;
  }
}

TEST(PartCases, AsFilesAreTheSameScenesAndPaths) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "tandem_part_cases_test";
  std::filesystem::create_directories(folder);
  for (const PartCase& given : {jamCase({}), dirtyShellsCase(Dirt::flipped)}) {
    const std::filesystem::path file = folder / (given.name + ".glb");
    const std::vector<unsigned char> bytes = glbOf(given);
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    const Result<assets::Scene> loaded = assets::loadGltf(file.string(), {});
    ASSERT_TRUE(loaded) << given.name;
    ASSERT_EQ(loaded->parts.size(), given.scene.parts.size());
    for (std::size_t i = 0; i < loaded->parts.size(); ++i) {
      const assets::Part &read = loaded->parts[i], &made = given.scene.parts[i];
      const assets::Mesh &readMesh = loaded->meshes[read.mesh], &madeMesh = given.scene.meshes[made.mesh];
      EXPECT_EQ(read.name, made.name);
      EXPECT_EQ(read.movable, made.movable);
      EXPECT_NEAR(read.massProperties.mass, read.movable ? made.massProperties.mass : 0.0, 1e-9);
      EXPECT_LT(glm::length(read.worldFromPart.position - made.worldFromPart.position), 1e-12);
      EXPECT_TRUE(readMesh.closed);
      EXPECT_NEAR(readMesh.volume, madeMesh.volume, 1e-5 * madeMesh.volume);
      EXPECT_EQ(loaded->materials[readMesh.triangleMaterial[0]].staticFriction,
                given.scene.materials[i].staticFriction);
    }
    const std::string csv = csvOf(given);
    EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')),
              1 + static_cast<std::size_t>(1000.0 * given.duration + 0.5));
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace tandem::test
