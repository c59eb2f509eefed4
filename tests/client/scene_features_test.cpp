#include "client/scene_features.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

using assets::Surface;
using assets::SurfaceTexture;

constexpr FeatureLimits kDesktop{200.0, 300.0, 3.3, 1000.0};

/// One part of one material with this surface.
assets::Scene sceneOf(const Surface& surface) {
  test::SceneBuilder b;
  b.scene.surfaces.push_back(surface);
  b.scene.materials[0].surface = 0;
  b.scene.materials[0].name = "stuff";
  b.addPart(test::sheetMesh(0.1, 2));
  b.scene.parts[0].name = "plate";
  return b.scene;
}

bool remarks(const assets::Scene& scene, const std::string& about, const FeatureLimits& limits = kDesktop) {
  const std::vector<Feature> features = surfaceFeatures(scene, limits);
  EXPECT_EQ(features.size(), 1u);
  return !features.empty() &&
         std::any_of(features[0].remarks.begin(), features[0].remarks.end(),
                     [&](const std::string& text) { return text.find(about) != std::string::npos; });
}

TEST(SceneFeatures, APlainSpringIsNotWorthALine) {
  EXPECT_TRUE(surfaceFeatures(sceneOf(Surface{}), kDesktop).empty());
}

TEST(SceneFeatures, ASurfaceIsNamedByPartMaterialAndAllItsEffects) {
  Surface s;
  s.creaseAngle = 0.5;
  s.viscosity = 3.0;
  s.texture = {SurfaceTexture::Pattern::sine, assets::kNoTexture, 2e-4, 0.0, 0.004, 2.0};
  s.vibrationFrequency = 80.0;
  s.vibrationAmplitude = 0.4;
  s.stickSlipForce = 0.5;
  s.stickSlipStiffness = 300.0;
  s.magneticForce = 0.8;
  s.magneticDistance = 0.01;
  s.popThroughForce = 1.5;
  s.law = Surface::Law::plastic;
  s.yieldForce = 1.0;
  s.hardening = 100.0;
  assets::Scene scene = sceneOf(s);
  scene.materials[0].stiffness = 150.0;
  scene.materials[0].staticFriction = 0.8;
  scene.materials[0].dynamicFriction = 0.5;
  const std::vector<Feature> features = surfaceFeatures(scene, kDesktop);
  ASSERT_EQ(features.size(), 1u);
  EXPECT_EQ(inOneLine(features[0]),
            "plate, stuff: stiffness 150 N/m; friction static 0.8, dynamic 0.5; shading creaseAngle 0.5 rad; "
            "texture sine, amplitude 0.0002 m, wavelength 0.004 m, frictionScale 2; viscosity 3 N·s/m; "
            "vibration frequency 80 Hz, amplitude 0.4 N; stick-slip force 0.5 N, stiffness 300 N/m; "
            "magnetic force 0.8 N, distance 0.01 m; pop-through force 1.5 N; "
            "law plastic, yield 1 N, hardening 100 N/m");
  EXPECT_TRUE(features[0].remarks.empty()) << features[0].remarks[0];
}

TEST(SceneFeatures, SaysWhatWillNotBeFeltAsWritten) {
  Surface s;
  s.vibrationFrequency = 600.0;
  s.vibrationAmplitude = 0.2;
  EXPECT_TRUE(remarks(sceneOf(s), "600 Hz cannot be shown"));
  s.vibrationFrequency = 499.0;
  EXPECT_FALSE(remarks(sceneOf(s), "cannot be shown"));
  s = Surface{};
  s.stickSlipForce = 0.3;
  EXPECT_TRUE(remarks(sceneOf(s), "stickSlip needs"));
  s = Surface{};
  s.magneticDistance = 0.3;
  EXPECT_TRUE(remarks(sceneOf(s), "magnetic needs"));
  s = Surface{};
  s.law = Surface::Law::viscoelastic;
  s.stiffness2 = 100.0;
  EXPECT_TRUE(remarks(sceneOf(s), "felt as elastic"));
  s.relaxation = 0.1;
  EXPECT_FALSE(remarks(sceneOf(s), "felt as elastic"));
  s = Surface{};
  s.texture.pattern = SurfaceTexture::Pattern::sine;
  s.texture.wavelength = 0.001;
  EXPECT_TRUE(remarks(sceneOf(s), "without an amplitude"));
  s.texture.amplitude = 0.0002;
  EXPECT_TRUE(remarks(sceneOf(s), "steeply"));
  s.texture.amplitude = 0.0001;
  EXPECT_FALSE(remarks(sceneOf(s), "steeply"));
  s = Surface{};
  s.popThroughForce = 4.0;
  EXPECT_TRUE(remarks(sceneOf(s), "popThrough at 4 N"));
  EXPECT_FALSE(remarks(sceneOf(s), "popThrough", {200.0, 300.0, 8.0, 1000.0}));
}

TEST(SceneFeatures, JudgesStiffnessByTheDevice) {
  assets::Scene scene = sceneOf(Surface{});
  scene.materials[0].stiffness = 301.0;
  EXPECT_TRUE(remarks(scene, "felt as 300 N/m"));
  EXPECT_FALSE(remarks(scene, "felt as", {0.0, 0.0, 3.3, 1000.0})) << "a device of which nothing is known";
  scene.materials[0].stiffness = 299.0;
  EXPECT_FALSE(remarks(scene, "felt as"));
  scene.materials[0].staticFriction = 0.2;
  scene.materials[0].dynamicFriction = 0.3;
  EXPECT_TRUE(remarks(scene, "dynamic friction"));
}

TEST(SceneFeatures, FieldsAndControlsSayWhatTheyAre) {
  assets::Scene scene = sceneOf(Surface{});
  assets::ForceField field;
  field.name = "anchor";
  field.kind = assets::ForceField::Kind::spring;
  field.stiffness = 300.0;
  field.maxForce = 5.0;
  scene.fields.push_back(field);
  assets::Control dial;
  dial.name = "mode";
  dial.part = 0;
  dial.kind = assets::ControlKind::dial;
  dial.min = -1.0;
  dial.max = 1.0;
  dial.inertia = 1e-5;
  dial.detents = {{-0.5, 0.5}, 0.02, 0.5};
  dial.roles = 4;
  scene.controls.push_back(dial);
  const Feature spring = fieldFeatures(scene, kDesktop).at(0);
  EXPECT_EQ(inOneLine(spring), "anchor, spring: energy conservative; limit maxForce 5 N; stiffness 300 N/m");
  EXPECT_EQ(spring.remarks.size(), 2u);
  const Feature mode = controlFeatures(scene, kDesktop).at(0);
  EXPECT_EQ(inOneLine(mode),
            "mode, dial, of plate: range min -1 rad, max 1 rad, value 0 rad; inertia 1e-05 kg·m^2; "
            "detents 2 places, force 0.02 N·m, width 0.5 rad; roles instructor");
  scene.controls[0].roles = 0;
  EXPECT_EQ(controlFeatures(scene, kDesktop).at(0).remarks.size(), 1u);
}

TEST(SceneFeatures, KeysOfJsonCarryTheUnit) {
  EXPECT_EQ(jsonKey({"maxForce", 1.0, "N"}), "max_force_n");
  EXPECT_EQ(jsonKey({"frictionScale", 1.0, ""}), "friction_scale");
  EXPECT_EQ(jsonKey({"damping", 1.0, "N·m·s/rad"}), "damping_nms_per_rad");
}

}  // namespace
}  // namespace tandem::client
