// Parts that touch their neighbours when they begin to move: nothing is felt and nothing moves.

#include <cstdlib>

#include "assets/gltf/load_gltf.h"
#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

void expectStill(PartCase given) {
  const Pose start = given.path(0.0);
  HeldPartRig rig(std::move(given));
  rig.run(0);
  report(rig);
  expectSound(rig);
  EXPECT_LT(rig.mostForce(), 0.01) << rig.given().name;
  EXPECT_LT(rig.mostTorque(), 1e-4) << rig.given().name;
  EXPECT_LT(rig.finalOffset(start), 5e-6) << rig.given().name;
}

TEST(StartsInContact, CubeOnABlock) { expectStill(cubeAtRestCase()); }
TEST(StartsInContact, PegAgainstItsBore) { expectStill(pegAtRestCase()); }

TEST(StartsInContact, EveryPartOfAnEngine) {
  const char* data = std::getenv("TANDEM_DATA");
  if (data == nullptr || !atFullSize()) GTEST_SKIP() << "set TANDEM_DATA and TANDEM_FULL_SIZE";
  assets::LoadOptions options;
  options.allMovable = true;
  options.unitScale = 1e-3;
  const Result<assets::Scene> loaded = assets::loadGltf(std::string(data) + "/2CylinderEngine.glb", options);
  ASSERT_TRUE(loaded);
  for (PartId part = 0; part < loaded->parts.size(); ++part) {
    const Pose pose = loaded->parts[part].worldFromPart;
    expectStill({loaded->parts[part].name, *loaded, part, [pose](double) { return pose; }, 0.05, {}});
  }
}

}  // namespace
}  // namespace tandem::test
