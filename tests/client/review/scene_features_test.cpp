#include "client/review/scene_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include <glm/geometric.hpp>

#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

using assets::Surface;
using assets::SurfaceTexture;

constexpr FeatureLimits kDesktop{200.0, 300.0, 3.3, 1000.0, 10.0};

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
                     [&](const Remark& remark) { return remark.text.find(about) != std::string::npos; });
}

TEST(SceneFeatures, APlainSpringIsNotWorthALine) {
  EXPECT_TRUE(surfaceFeatures(sceneOf(Surface{}), kDesktop).empty());
}

TEST(SceneFeatures, ASurfaceIsNamedByPartMaterialAndAllItsEffects) {
  Surface s;
  s.viscosity = 3.0;
  s.texture = {SurfaceTexture::Pattern::sine, assets::kNoTexture, 2e-4, 0.0, 0.004, 2.0};
  s.vibrationFrequency = 80.0;
  s.vibrationAmplitude = 0.4;
  s.stickSlipForce = 0.5;
  s.stickSlipStiffness = 300.0;
  s.magneticForce = 0.7;
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
            "plate, stuff: stiffness 150 N/m; friction static 0.8, dynamic 0.5; "
            "texture sine, amplitude 0.0002 m, wavelength 0.004 m, frictionScale 2; viscosity 3 N·s/m; "
            "vibration frequency 80 Hz, amplitude 0.4 N; stick-slip force 0.5 N, stiffness 300 N/m; "
            "magnetic force 0.7 N, distance 0.01 m; pop-through force 1.5 N; "
            "law plastic, yield 1 N, hardening 100 N/m");
  EXPECT_TRUE(features[0].remarks.empty()) << features[0].remarks[0].text;
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
  EXPECT_FALSE(remarks(sceneOf(s), "popThrough", {200.0, 300.0, 8.0, 1000.0, 10.0}));
}

TEST(SceneFeatures, JudgesStiffnessByTheDevice) {
  assets::Scene scene = sceneOf(Surface{});
  scene.materials[0].stiffness = 301.0;
  EXPECT_TRUE(remarks(scene, "felt as 300 N/m"));
  EXPECT_FALSE(remarks(scene, "felt as", {0.0, 0.0, 3.3, 1000.0, 10.0}))
      << "a device of which nothing is known";
  scene.materials[0].stiffness = 299.0;
  EXPECT_FALSE(remarks(scene, "felt as"));
  scene.materials[0].staticFriction = 0.2;
  scene.materials[0].dynamicFriction = 0.3;
  EXPECT_TRUE(remarks(scene, "dynamic friction"));
}

TEST(SceneFeatures, SaysWhatADeviceHoldsBackOfASurface) {
  assets::Scene scene = sceneOf(Surface{});
  scene.materials[0].damping = 10.1;
  EXPECT_TRUE(remarks(scene, "damping is felt as 10 N·s/m"));
  scene.materials[0].damping = 9.9;
  EXPECT_FALSE(remarks(scene, "damping"));
  Surface s;
  s.viscosity = 50.0;
  EXPECT_TRUE(remarks(sceneOf(s), "viscosity is felt as 10 N·s/m"));
  s = Surface{};
  s.stickSlipForce = 0.5;
  s.stickSlipStiffness = 301.0;
  EXPECT_TRUE(remarks(sceneOf(s), "stick-slip stiffness is felt as 300 N/m"));
  s.stickSlipStiffness = 299.0;
  EXPECT_FALSE(remarks(sceneOf(s), "stick-slip stiffness"));
  s = Surface{};
  s.magneticForce = 0.76;  // 4 F / distance = 304 N/m
  s.magneticDistance = 0.01;
  EXPECT_TRUE(remarks(sceneOf(s), "changes by 304 N/m, more than the 300 N/m"));
  s.magneticForce = 0.74;
  EXPECT_FALSE(remarks(sceneOf(s), "magnetic"));
  s.magneticForce = 4.0;
  s.magneticDistance = 1.0;
  EXPECT_TRUE(remarks(sceneOf(s), "magnetic pull: 4 N is more than the 3.3 N"));
}

TEST(SceneFeatures, SaysWhenACreaseAngleShadesNothingOrEverything) {
  const auto of = [](const assets::Mesh& mesh, double crease) {
    Surface s;
    s.creaseAngle = crease;
    assets::Scene scene = sceneOf(s);
    scene.meshes[0] = mesh;
    return scene;
  };
  const assets::Mesh box = test::boxMesh({0.1, 0.1, 0.1});
  EXPECT_TRUE(remarks(of(box, 0.5236), "shades nothing: no edge turns by less than 1.571 rad"));
  EXPECT_TRUE(remarks(of(box, 1.6), "shades everything: also edges that turn by 1.571 rad"));
  EXPECT_TRUE(remarks(of(test::sheetMesh(0.1, 2), 0.5), "shades nothing: the surface is flat"));
  const assets::Mesh sphere = test::sphereMesh(0.05, 16);
  EXPECT_FALSE(remarks(of(sphere, 0.5236), "creaseAngle")) << "all edges are below it, as they should be";
  EXPECT_TRUE(remarks(of(sphere, 1e-3), "shades nothing"));
}

TEST(SceneFeatures, SaysThatTheNormalsOfTheFileAreFelt) {
  assets::Scene scene = sceneOf(Surface{});
  scene.materials[0].surface = assets::kNone;
  scene.meshes[0] = test::sphereMesh(0.05, 16);
  EXPECT_TRUE(surfaceFeatures(scene, kDesktop).empty());
  assets::Mesh& mesh = scene.meshes[0];
  for (const auto& t : mesh.triangles) {
    auto& normals = mesh.triangleNormal.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) normals[c] = glm::vec3(glm::normalize(mesh.positions[t[c]]));
  }
  const std::vector<Feature> features = surfaceFeatures(scene, kDesktop);
  ASSERT_EQ(features.size(), 1u);
  EXPECT_EQ(inOneLine(features[0]), "plate, stuff: shading by the normals of the file, triangles " +
                                        std::to_string(mesh.triangles.size()));
}

TEST(SceneFeatures, OneLineNamesAllThatARemarkIsTrueOf) {
  Surface s;
  s.viscosity = 50.0;
  assets::Scene scene = sceneOf(s);
  for (int i = 0; i < 3; ++i) {
    scene.parts.push_back(scene.parts[0]);
    scene.parts.back().name = "plate " + std::to_string(i);
  }
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].damping = 20.0;
  scene.meshes.push_back(scene.meshes[0]);
  std::fill(scene.meshes[1].triangleMaterial.begin(), scene.meshes[1].triangleMaterial.end(), 1);
  scene.parts[3].mesh = 1;
  const std::vector<Feature> features = surfaceFeatures(scene, kDesktop);
  const std::vector<RemarkGroup> groups = groupRemarks(features);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].text, "viscosity is felt as 10 N·s/m, the most on this device");
  EXPECT_EQ(groups[0].example, "plate");
  EXPECT_EQ(groups[0].features, 4u);
  EXPECT_EQ(groups[0].materials, 2u);
  EXPECT_EQ(groups[1].example, "plate 2");
  EXPECT_EQ(groups[1].features, 1u);
  const std::vector<Feature> lines = oneEachMaterial(features);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(inOneLine(lines[0]), "plate and 2 more, stuff: viscosity 50 N·s/m");
  EXPECT_EQ(inOneLine(lines[1]), "plate 2, stuff: damping 20 N·s/m; viscosity 50 N·s/m");
}

TEST(SceneFeatures, FieldsNameAllTheirParameters) {
  using Kind = assets::ForceField::Kind;
  const auto lineOf = [](const assets::ForceField& field) {
    assets::Scene scene = sceneOf(Surface{});
    scene.fields.push_back(field);
    return inOneLine(fieldFeatures(scene, kDesktop).at(0));
  };
  assets::ForceField f;
  f.name = "f";
  f.kind = Kind::viscosity;
  f.damping = glm::dvec3(20.0);
  f.region = {assets::FieldRegion::Kind::box, {0.1, 0.2, 0.3}, 0.0, 0.01};
  EXPECT_EQ(lineOf(f),
            "f, viscosity: energy dissipative; limit maxForce 3 N; damping 20 N·s/m; "
            "region box, x 0.2 m, y 0.4 m, z 0.6 m, fade 0.01 m");
  assets::Scene scene = sceneOf(Surface{});
  scene.fields.push_back(f);
  EXPECT_EQ(fieldFeatures(scene, kDesktop).at(0).remarks.at(0).text,
            "damping is felt as 10 N·s/m, the most on this device");
  f = {};
  f.name = "f";
  f.kind = Kind::guide;
  f.anchor = assets::ForceField::Anchor::path;
  f.points.resize(5);
  f.stiffness = 180.0;
  f.radius = 0.003;
  f.range = 0.03;
  f.fade = 0.007;
  f.drive = 0.5;
  EXPECT_EQ(lineOf(f),
            "f, guide: energy source; limit maxForce 3 N; spring path of 5 points, stiffness 180 N/m, "
            "radius 0.003 m, range 0.03 m, fade 0.007 m, drive 0.5 N");
  f = {};
  f.name = "f";
  f.kind = Kind::gravity;
  f.radius = 0.5;
  f.strength = 0.25;
  EXPECT_EQ(lineOf(f),
            "f, gravity: energy conservative; limit maxForce 3 N; gravity surfaceForce 1 N, radius 0.5 m; "
            "stiffness 4 N/m");
}

TEST(SceneFeatures, JudgesControlsByTheDevice) {
  const auto says = [](const assets::Control& control, const std::string& about) {
    assets::Scene scene = sceneOf(Surface{});
    scene.controls.push_back(control);
    const Feature feature = controlFeatures(scene, kDesktop).at(0);
    return std::any_of(feature.remarks.begin(), feature.remarks.end(),
                       [&](const Remark& remark) { return remark.text.find(about) != std::string::npos; });
  };
  assets::Control slider;
  slider.part = 0;
  slider.kind = assets::ControlKind::slider;
  slider.max = 0.07;
  slider.inertia = 0.05;
  EXPECT_FALSE(says(slider, ""));
  slider.detents.places = {0.0, 0.035, 0.07};
  EXPECT_TRUE(says(slider, "detents without a force"));
  slider.detents.force = 1.0;  // 2 pi F / 35 mm = 180 N/m
  EXPECT_FALSE(says(slider, ""));
  slider.detents.width = 0.02;  // 314 N/m
  EXPECT_TRUE(says(slider, "rise by 314.2 N/m"));
  slider.detents.force = 3.4;
  EXPECT_TRUE(says(slider, "its detents: 3.4 N is more than the 3.3 N"));
  slider.detents = {};
  slider.click = {0.03, 0.0, 0.01};
  EXPECT_TRUE(says(slider, "click without a drop"));
  slider.click.drop = 4.0;
  EXPECT_TRUE(says(slider, "its click: 4 N"));
  slider.click = {};
  slider.springStiffness = 301.0;
  EXPECT_TRUE(says(slider, "its spring is stiffer"));
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
  EXPECT_EQ(inOneLine(spring),
            "anchor, spring: energy conservative; limit maxForce 5 N; spring point, stiffness 300 N/m");
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
