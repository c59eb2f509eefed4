// What is said of a shaft in a bore of its radius, to which loading has given room.

#include <gtest/gtest.h>

#include "assets/gltf/load_gltf.h"
#include "client/review/clash_check.h"
#include "client/review/measure.h"
#include "haptics/scene/contact_scene.h"
#include "tests/support/exact_fit_file.h"

namespace tandem::test {
namespace {

using client::ClashKind;

assets::Scene pinInBore(double play) {
  ExactFit fit;
  fit.play = play;
  assets::LoadOptions options;
  options.movable = {"pin"};
  Result<assets::Scene> scene = assets::loadGltfFromMemory("fit.glb", exactFitFile(fit).glb(), options);
  EXPECT_TRUE(scene.ok());
  return std::move(scene).value();
}

/// The pin where the file has it, moved.
std::optional<client::Clash> answerFor(const assets::Scene& scene, const Pose& moved) {
  const haptics::ContactScene contact(scene, 1);
  const client::PartClosings closings(contact);
  return client::measurePair(closings, 0, moved, 1, Pose{});
}

client::ClashReport reportOf(const assets::Scene& scene) {
  client::ClashOptions options;
  options.threads = 1;
  return client::findClashes(haptics::ContactScene(scene, 1), options);
}

TEST(EqualFitClash, APinTouchesTheBoreOfItsRadius) {
  const assets::Scene scene = pinInBore(0.0);
  const client::ClashReport report = reportOf(scene);
  ASSERT_EQ(report.clashes.size(), 1u);
  EXPECT_EQ(report.clashes[0].kind, ClashKind::touch);
  EXPECT_EQ(report.clashes[0].distance, 0.0);
  // Turned, slid, and aside within its room.
  for (const double angle : {0.0, 0.03, 0.7})
    for (const double height : {0.0, -0.001, 0.002})
      for (const double aside : {0.0, 2e-6}) {
        const Pose pose{{aside, 0.0, height}, fromRotationVector({0.0, 0.0, angle})};
        const std::optional<client::Clash> clash = answerFor(scene, pose);
        ASSERT_TRUE(clash.has_value());
        EXPECT_EQ(clash->kind, ClashKind::touch) << angle << ' ' << height << ' ' << aside;
        EXPECT_EQ(clash->distance, 0.0);
      }
}

TEST(EqualFitClash, BothHaveTheDiameterThatTheFileStates) {
  for (const double play : {0.0, 4e-6, 5e-6}) {
    const assets::Scene scene = pinInBore(play);
    const haptics::ContactScene contact(scene, 1);
    for (const PartId part : {PartId{0}, PartId{1}}) {
      const auto place = client::measurePlaceOn(contact, part, {0.010, 0.0, -0.002});
      ASSERT_TRUE(place && place->cylinder);
      EXPECT_NEAR(place->cylinder->radius, 0.010 + (part == 1 ? play : 0.0), 1e-8) << play;
    }
  }
}

TEST(EqualFitClash, APinThatHasLeftItsBoreIsApart) {
  const assets::Scene scene = pinInBore(0.0);
  const std::optional<client::Clash> out = answerFor(scene, {glm::dvec3(0.0, 0.0, 0.02), {}});
  ASSERT_TRUE(out.has_value());
  EXPECT_EQ(out->kind, ClashKind::clearance);
  // Its end a micrometre over the rim.
  const std::optional<client::Clash> above = answerFor(scene, {glm::dvec3(0.0004, 0.0, 0.006 + 1e-6), {}});
  ASSERT_TRUE(above.has_value());
  EXPECT_EQ(above->kind, ClashKind::clearance);
}

TEST(EqualFitClash, APinWithPlayHasThatClearance) {
  for (const double play : {2e-6, 3e-6, 3.4e-6, 3.7e-6, 3.9e-6, 4.2e-6, 4.6e-6, 5e-6, 6e-6}) {
    const assets::Scene scene = pinInBore(play);
    EXPECT_TRUE(reportOf(scene).clashes.empty());
    const std::optional<client::Clash> clash = answerFor(scene, {});
    ASSERT_TRUE(clash.has_value());
    EXPECT_EQ(clash->kind, ClashKind::clearance);
    EXPECT_NEAR(clash->distance, play, 0.15 * play + 1e-7);
  }
}

}  // namespace
}  // namespace tandem::test
